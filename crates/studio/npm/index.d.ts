/** A mistake in a study; `from` and `to` count bytes of UTF-8. */
export interface Diagnostic {
  from: number;
  to: number;
  line: number;
  column: number;
  message: string;
  expected: string;
  help: string | null;
  severity: "error" | "warning";
}

export class StudioError extends Error {
  diagnostics: Diagnostic[];
  /** The text that the command prints. */
  rendered: string;
}

/** The text of a study in TOML, or a text with its name and format. */
export type Study = string | { text: string; name?: string; format?: "toml" | "json" };
/** Files by their names, with `/` between folder and name. */
export type Files = Record<string, Uint8Array>;
/** The files that a study reads, such as its log. */
export type Inputs = Record<string, Uint8Array | string>;
export type Language = "c" | "rust" | "fmu2" | "fmu3";

export interface Progress {
  stage: string;
  what: string;
  done: number;
  of: number;
}

export interface Outlined {
  path: (string | number)[];
  from: number;
  to: number;
  key_from: number | null;
  key_to: number | null;
  kind: string;
}

export interface About {
  version: string;
  schema: Record<string, unknown>;
  kinds: { name: string; about: string }[];
  templates: { name: string; title: string | null; about: string; text: string; files: string[] }[];
  files: Files;
}

export interface Check {
  diagnostics: Diagnostic[];
  rendered: string;
  title: string | null;
  outline: Outlined[];
  observers: { name: string; kind: string }[] | null;
  plant: { states: string[]; inputs: string[]; outputs: string[] } | null;
  exports: { observer: string; languages: Language[] }[] | null;
  warnings: string[];
  estimate: { seconds: number; memory_bytes: number; in_words: string } | null;
}

export interface Run {
  /** The content of study.json. */
  results: Record<string, unknown>;
  /** The text that the command prints. */
  summary: string;
  failures: { observer: string; message: string }[];
  warnings: string[];
  stopped: string | null;
  files: Files;
}

export interface Exported {
  observer: string;
  text: string;
  proved: boolean;
  statement: string;
  files: Files;
}

export interface Verified {
  verdict: "proved" | "rejected" | "unreadable";
  rendered: string;
}

export interface Proposed {
  text: string;
  /** The study with what was found. */
  study: string;
  results: Record<string, unknown>;
  files: Files;
}

export interface Columns {
  columns: string[];
  rows: number;
  suggestion: string;
}

export class Studio {
  ask(
    json: Record<string, unknown>,
    files?: Inputs,
    progress?: ((progress: Progress) => void) | null,
  ): Record<string, unknown> & { files: Files };
  about(): About;
  check(study: Study, files?: Inputs): Check;
  run(
    study: Study,
    files?: Inputs,
    options?: {
      step?: string;
      figures?: boolean;
      limit_seconds?: number | null;
      progress?: ((progress: Progress) => void) | null;
    },
  ): Run;
  export(
    study: Study,
    files?: Inputs,
    options?: {
      observer?: string | null;
      language?: Language;
      period?: number | null;
      scalar?: string;
      feedback?: boolean;
      unproved?: boolean;
    },
  ): Exported;
  verify(certificate: Uint8Array | string, name?: string): Verified;
  advise(
    study: Study,
    files?: Inputs,
    options?: { limit_seconds?: number | null; progress?: ((progress: Progress) => void) | null },
  ): Proposed;
  tune(
    study: Study,
    files?: Inputs,
    options?: { limit_seconds?: number | null; progress?: ((progress: Progress) => void) | null },
  ): Proposed;
  columns(name: string, csv: Uint8Array | string, study?: Study | null): Columns;
  zip(files: Inputs): Uint8Array;
}

/** Compiles the module: its bytes, or a compiled one. */
export function load(module: BufferSource | WebAssembly.Module): Promise<Studio>;

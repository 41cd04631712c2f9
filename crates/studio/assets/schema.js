// What a study may hold, from study.schema.json.

// study.schema.json: what may stand at a path, and what it is for.
class Schema {
  constructor(schema) {
    this.schema = schema;
  }

  // The schemas of a path; of the kinds of an observer that one whose `kind` the text has.
  at(path, toml) {
    let found = [this.schema];
    const walked = [];
    for (const step of path) {
      found = found.flatMap((schema) => this.step(schema, step));
      walked.push(step);
      found = found.flatMap((schema) => this.narrowed(schema, toml?.get(walked)));
    }
    return found;
  }

  step(schema, step) {
    const inner = [...(schema.anyOf ?? []), ...(schema.oneOf ?? [])].flatMap((one) => this.step(one, step));
    if (typeof step === "number") return schema.items ? [schema.items] : inner;
    if (schema.properties?.[step]) return [schema.properties[step]];
    if (schema.additionalProperties && schema.type === "object") return [schema.additionalProperties];
    // The items of an array that is asked for a key: an inline table in it.
    if (schema.items?.properties || schema.items?.oneOf) return this.step(schema.items, step);
    return inner;
  }

  narrowed(schema, node) {
    if (!schema.oneOf?.some((one) => one.properties)) return [schema];
    const fits = schema.oneOf.filter((one) =>
      Object.entries(one.properties).every(([key, { const: value }]) => {
        const written = node?.members?.find((member) => member.key === key)?.node.value;
        return value === undefined || written === undefined || written === value;
      }),
    );
    return fits.length ? fits : schema.oneOf;
  }

  // The keys of a table: name, description, schema, whether it is required.
  keys(path, toml) {
    const keys = new Map();
    for (const schema of this.at(path, toml)) {
      for (const one of [schema, ...(schema.anyOf ?? [])]) {
        for (const [name, inner] of Object.entries(one.properties ?? {})) {
          if (!keys.has(name)) keys.set(name, { name, schema: inner, required: one.required?.includes(name) });
        }
      }
    }
    return [...keys.values()];
  }

  // The values of a key that has only a few: value and description.
  choices(path, toml) {
    const choices = new Map();
    const walk = (schema) => {
      if (schema.const !== undefined) choices.set(schema.const, schema.description ?? "");
      for (const value of schema.enum ?? []) choices.set(value, "");
      if (schema.type === "boolean") for (const value of [true, false]) choices.set(value, "");
      for (const one of [...(schema.oneOf ?? []), ...(schema.anyOf ?? [])]) walk(one);
      if (schema.items) walk(schema.items);
    };
    const parent = path.slice(0, -1);
    const key = path.at(-1);
    // A tag such as `kind` is that of every variant, not of the chosen one.
    const tagged = this.untagged(parent).flatMap((schema) =>
      (schema.oneOf ?? []).flatMap((one) => (one.properties?.[key]?.const === undefined ? [] : [one.properties[key]])),
    );
    for (const schema of tagged.length ? tagged : this.at(path, toml)) walk(schema);
    return [...choices].map(([value, description]) => ({ value, description }));
  }

  untagged(path) {
    let found = [this.schema];
    for (const step of path) found = found.flatMap((schema) => this.step(schema, step));
    return found;
  }

  describe(path, toml) {
    return (
      this.at(path, toml)
        .map((schema) => schema.description)
        .find((text) => text) ?? ""
    );
  }

  // Whether a value of the path may be a text, as an expression in place of a number may.
  texts(path, toml) {
    const may = (schema) =>
      schema.type === "string" ||
      (Array.isArray(schema.type) && schema.type.includes("string")) ||
      [...(schema.anyOf ?? []), ...(schema.oneOf ?? [])].some(may) ||
      (schema.items && may(schema.items)) ||
      schema.enum?.some((value) => typeof value === "string");
    return this.at(path, toml).some(may);
  }

  // What is written for a new value.
  template(schema) {
    const type = Array.isArray(schema.type) ? schema.type[0] : schema.type;
    const first = schema.const ?? schema.oneOf?.find((one) => one.const !== undefined)?.const ?? schema.enum?.[0];
    if (first !== undefined) return typeof first === "string" ? quoted(first) : String(first);
    if (type === "string") return '""';
    if (type === "boolean") return "true";
    if (type === "number" || type === "integer") return String(schema.minimum ?? 1);
    if (type === "array") {
      const inner = schema.items ? this.template(schema.items) : "";
      return `[${Array(schema.minItems ?? 1)
        .fill(inner)
        .join(", ")}]`;
    }
    if (type === "object") {
      const needed = (schema.required ?? []).map((key) => `${key} = ${this.template(schema.properties[key])}`);
      return needed.length ? `{ ${needed.join(", ")} }` : "{}";
    }
    const one = schema.anyOf?.[0] ?? schema.oneOf?.[0];
    return one ? this.template(one) : '""';
  }
}

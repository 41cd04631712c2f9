// Bytes: texts and their places, compressed letters in addresses, files that are saved.

const encode = (text) => new TextEncoder().encode(text);
const decode = (bytes) => new TextDecoder().decode(bytes);

// A size in the units of files.
function size(bytes) {
  if (bytes < 1000) return `${bytes} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toPrecision(3)} kB`;
  return `${(bytes / 1e6).toPrecision(3)} MB`;
}

// From offsets in UTF-8, as the module counts, to offsets in a text of JavaScript.
function places(text) {
  const bytes = encode(text);
  if (bytes.length === text.length) return (offset) => Math.min(offset, text.length);
  const map = new Uint32Array(bytes.length + 1);
  let unit = 0;
  for (let byte = 0; byte < bytes.length; byte++) {
    map[byte] = unit;
    // The last byte of a character ends it; one of four bytes is two units.
    const next = bytes[byte + 1];
    if (next === undefined || (next & 0xc0) !== 0x80) {
      let first = byte;
      while ((bytes[first] & 0xc0) === 0x80) first--;
      unit += bytes[first] >= 0xf0 ? 2 : 1;
    }
  }
  map[bytes.length] = text.length;
  return (offset) => map[Math.min(offset, bytes.length)];
}

// The bytes that an element of the page holds in the base 85 of reports.
function packedBytes(letters) {
  const text = letters.trim();
  const digits = new Uint8Array(128);
  for (let code = 33, digit = 0; code < 127; code++) {
    if (!"\"&'<>\\`,;".includes(String.fromCharCode(code))) digits[code] = digit++;
  }
  const bytes = new Uint8Array(Math.floor((text.length * 4) / 5));
  for (let from = 0, to = 0; from < text.length; from += 5) {
    let word = 0;
    for (let place = from; place < from + 5; place++) {
      word = word * 85 + (place < text.length ? digits[text.charCodeAt(place)] : 84);
    }
    for (let shift = 24; shift >= 0 && to < bytes.length; shift -= 8) bytes[to++] = word / 2 ** shift;
  }
  return bytes;
}

// What a stream gives, up to a number of bytes.
async function gathered(stream, most) {
  const parts = [];
  let sum = 0;
  const reader = stream.getReader();
  for (;;) {
    const { done, value } = await reader.read();
    if (done) break;
    sum += value.length;
    if (sum > most) {
      reader.cancel().catch(() => {});
      throw new Error(`it has more than ${size(most)}`);
    }
    parts.push(value);
  }
  const bytes = new Uint8Array(sum);
  let place = 0;
  for (const part of parts) {
    bytes.set(part, place);
    place += part.length;
  }
  return bytes;
}

const through = (bytes, transform, most) => gathered(new Blob([bytes]).stream().pipeThrough(transform), most);

// A text as letters that may stand in an address, compressed, and back. The sum of zlib tells what was cut or changed.
async function toLetters(text) {
  const bytes = await through(encode(text), new CompressionStream("deflate"), 1e9);
  let letters = "";
  for (let from = 0; from < bytes.length; from += 8192)
    letters += String.fromCharCode(...bytes.subarray(from, from + 8192));
  return btoa(letters).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "");
}

async function fromLetters(letters, most) {
  if (!letters) throw new Error("it is empty");
  if (!/^[A-Za-z0-9_-]+$/.test(letters)) throw new Error("it has letters that no link has");
  const bytes = Uint8Array.from(atob(letters.replace(/-/g, "+").replace(/_/g, "/")), (letter) => letter.charCodeAt(0));
  return new TextDecoder("utf-8", { fatal: true }).decode(
    await through(bytes, new DecompressionStream("deflate"), most),
  );
}

function download(name, bytes, type = "application/octet-stream") {
  const address = URL.createObjectURL(new Blob([bytes], { type }));
  const link = element("a", { href: address, download: name.split("/").pop() });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

const types = {
  html: "text/html",
  json: "application/json",
  csv: "text/csv",
  svg: "image/svg+xml",
  png: "image/png",
  zip: "application/zip",
};
const typeOf = (name) => types[name.split(".").pop()] ?? (isText(name) ? "text/plain" : "application/octet-stream");
const isText = (name) =>
  /\.(html|json|csv|svg|toml|c|h|rs|md|txt|py|xml|v|lock|gitignore)$|(^|\/)(CMakeLists|Makefile)[^/]*$/.test(name);

// Behind the use of the page: runs the studies of STUDIES and leaves the SHA-256 of their files in `test-bits`.
(async () => {
  while (!document.getElementById("test-result")) await new Promise((done) => setTimeout(done, 5));
  // As in the use of the page: under a virtual clock, workers need work in which time passes.
  let spun = 1;
  const spinning = setInterval(() => { for (let k = 0; k < 1e7; k++) spun = Math.imul(spun, 48271); }, 20);
  const found = {};
  try {
    for (const { name, text, files } of STUDIES) {
      const named = new Map(Object.entries(files).map(([file, content]) => [file, new TextEncoder().encode(content)]));
      const request = { do: "run", step: "run", figures: false, name: `${name}.toml`, study: text, format: "toml" };
      const answer = await studio.runner.ask(request, { named });
      found[name] = {};
      for (const file of answer.files) {
        const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", file.bytes));
        found[name][file.name] = [...digest].map((byte) => byte.toString(16).padStart(2, "0")).join("");
      }
    }
  } catch (error) {
    found.error = String(error.stack ?? error);
  }
  clearInterval(spinning);
  const result = document.createElement("pre");
  result.id = "test-bits";
  result.textContent = JSON.stringify(found);
  document.body.append(result);
})();

// Typesets formulas: a list of [TeX, whether it is displayed] on standard input, a list of HTML on standard output.
const katex = require("katex");
let text = "";
process.stdin.on("data", (part) => (text += part));
process.stdin.on("end", () => {
  const made = JSON.parse(text).map(([formula, displayMode]) =>
    katex.renderToString(formula.trim(), { displayMode, throwOnError: true, strict: "ignore" }),
  );
  process.stdout.write(JSON.stringify(made));
});

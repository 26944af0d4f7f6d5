// The hosts: the packages, the files, the build and the start of each project.
//
//   name       the name in the table
//   install    further npm packages besides the package and three.js
//   files      files of the project: text, `from` a file in project/, or `readme`, code of a language in the README
//   build      commands, in order
//   serve      the folder for a file server, or the command of a server, with PORT instead of the port
//   run        a command that prints the result
//   hasInline  whether the page has an inline script, which the policy of the README forbids
//   needs      the steps besides installing the package

const page = (script) => `<!doctype html><meta charset="utf-8"><title>walk</title><link rel="icon" href="data:,"><script type="module" src="${script}"></script>`;

/** Copies the module next to the bundle, because the bundler does not copy it. */
const COPY = "cp node_modules/mocap-wasm/mocap.wasm dist/";

const vite = (version) => [
  {
    name: `Vite ${version}, development`, install: [`vite@${version}`], files: { "index.html": page("/main.js") },
    serve: "npx vite --port PORT --strictPort --host 127.0.0.1", needs: "nothing",
  },
  {
    name: `Vite ${version}, build`, install: [`vite@${version}`], files: { "index.html": page("/main.js") },
    build: ["npx vite build"], serve: "dist", needs: "nothing",
  },
];

const next = (version, flags) => ({
  name: `Next.js ${version}`, install: [`next@${version}`, "react@19", "react-dom@19"],
  files: {
    "app/page.js": { from: "next_page.js" },
    "app/layout.js": "export default function Layout({ children }) {\n  return <html lang=\"en\"><body>{children}</body></html>;\n}\n",
  },
  build: [`npx next build ${flags}`], serve: "npx next start --port PORT", needs: "nothing; `\"use client\"`",
});

export const HOSTS = [
  ...[5, 6, 7, 8].flatMap(vite),
  {
    name: "Vite 8, worker", install: ["vite@8"], files: { "index.html": page("/page_of_worker.js"), "vite.config.js": "export default { worker: { format: \"es\" } };\n" },
    build: ["npx vite build"], serve: "dist", needs: "nothing; workers that are modules",
  },
  {
    name: "webpack 5", install: ["webpack@5", "webpack-cli@6"], files: { "dist/index.html": page("main.js") },
    build: ["npx webpack --mode production --entry ./main.js"], serve: "dist", needs: "nothing",
  },
  {
    name: "webpack 5, worker", install: ["webpack@5", "webpack-cli@6"], files: { "dist/index.html": page("main.js") },
    build: ["npx webpack --mode production --entry ./page_of_worker.js"], serve: "dist", needs: "nothing",
  },
  {
    name: "esbuild", install: ["esbuild"], files: { "dist/index.html": page("main.js") },
    build: ["npx esbuild main.js --bundle --format=esm --outdir=dist", COPY], serve: "dist", needs: "`mocap.wasm` copied beside the bundle",
  },
  {
    name: "Rollup 4", install: ["rollup@4", "@rollup/plugin-node-resolve"], files: { "dist/index.html": page("main.js") },
    build: ["npx rollup main.js --plugin node-resolve --format es --dir dist", COPY], serve: "dist", needs: "`mocap.wasm` copied beside the bundle",
  },
  {
    name: "React Three Fiber 9, in Vite 8", install: ["vite@8", "react@19", "react-dom@19", "@react-three/fiber@9"],
    files: { "index.html": page("/fiber.jsx"), "fiber.jsx": { from: "fiber.jsx" }, "use_mocap.jsx": { readme: "jsx" } },
    build: ["npx vite build"], serve: "dist", hasInline: true, needs: "the hook of [package/README.md](package/README.md)",
  },
  next(15, ""),
  next(16, ""),
  {
    name: "`<script type=module>`", install: [],
    files: {
      "index.html": page("/main.js").replace("<script", `<script type="importmap">{ "imports": {
        "three": "/node_modules/three/build/three.module.js",
        "mocap-wasm": "/node_modules/mocap-wasm/index.js", "mocap-wasm/three": "/node_modules/mocap-wasm/three.js" } }</script><script`),
    },
    serve: ".", hasInline: true, needs: "a map of imports, for three.js",
  },
  { name: "Node", install: [], run: "node command.js", needs: "20.16 or later" },
  { name: "Node, thread", install: [], run: "node thread.js", needs: "20.16 or later" },
  { name: "Deno 2", install: ["deno@2"], run: "npx deno run --allow-read --allow-env command.js", needs: "`--allow-read`" },
];

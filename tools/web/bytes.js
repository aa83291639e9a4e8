// How many bytes the page fetches of a file until its first mesh, and until a focus box shows the original inside:
//
//   node bytes.js FILE.ptet FOCUS...       FOCUS: x,y,z,x,y,z, each in a page of its own; nothing else is asked
//
// Needs what build.sh makes. For each answer of the page: the tets, and the part of the file that was fetched by then.
import { basename, dirname } from "node:path";
import { serve, settled, startBrowser } from "./browser.js";

const [file, ...boxes] = process.argv.slice(2);
const server = await serve([dirname(file)]);
const browser = await startBrowser({ width: 1200, height: 800 });
const { page } = browser;

/** By answer of the page: { tets, of, bytes, all, requests, limitedBy }. */
async function answersTo(parameters) {
  await page.goto(`${server.url}index.html?${new URLSearchParams({ file: basename(file), ...parameters })}`);
  await settled(page, 600);
  return page.evaluate(() => window.answers);
}

try {
  await page.addInitScript(() => {
    window.answers = [];
    document.addEventListener("DOMContentLoaded", () => {
      const element = (id) => document.getElementById(id);
      const note = () =>
        window.answers.push({
          tets: Number(element("tets").dataset.value),
          ...Object.fromEntries(Object.entries(element("fetched").dataset).map(([name, text]) => [name, Number(text)])),
          limitedBy: element("limited-by").textContent,
        });
      new MutationObserver(note).observe(element("time"), { childList: true });
    });
  });
  const requests = [{ error: "any" }, ...boxes.map((focus) => ({ error: "any", focus }))];
  for (const request of requests) {
    const answers = await answersTo(request);
    console.log(JSON.stringify(request));
    for (const { tets, bytes, of, requests: count, limitedBy } of [answers[0], answers.at(-1)])
      console.log(`  ${tets} tets, ${limitedBy}: ${bytes} bytes, ${((100 * bytes) / of).toFixed(2)}%, ${count} requests`);
  }
} finally {
  await browser.close();
  server.stop();
}

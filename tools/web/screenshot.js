// A picture of the page, served here or elsewhere:
//
//   node screenshot.js FOLDER-OF-FILES OUTPUT.png PARAMETERS-OF-A-LINK
//   node screenshot.js URL OUTPUT.png
import { serve, settled, startBrowser } from "./browser.js";

const [from, output, parameters] = process.argv.slice(2);
const server = /^https?:/.test(from) ? null : await serve([from]);
const browser = await startBrowser({ width: 1280, height: 800 });
try {
  await browser.page.goto(server ? `${server.url}index.html?${parameters}` : from);
  await settled(browser.page);
  const problem = await browser.page.locator("#problem").textContent();
  if (problem !== "") throw new Error(problem);
  await browser.page.screenshot({ path: output });
} finally {
  await browser.close();
  server?.stop();
}

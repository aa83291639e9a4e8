// Chromium without a display, and a server for it: what the test and the picture's script share.
import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { chromium } from "playwright-core";

export const here = dirname(fileURLToPath(import.meta.url));

/** The page, and these folders, by serve.py; { url, stop() }. */
export function serve(folders, options = []) {
  return new Promise((resolve, reject) => {
    const server = spawn("python3", [join(here, "serve.py"), ...(options.includes("--port") ? [] : ["--port", "0"]), ...options, ...folders], {
      stdio: ["ignore", "pipe", "inherit"],
    });
    server.once("error", reject);
    server.once("exit", (code) => reject(new Error(`serve.py ended with ${code}`)));
    server.stdout.once("data", (line) => resolve({ url: String(line).trim(), stop: () => server.kill() }));
  });
}

/** A browser of its own, which draws in software; { page, close() }. */
export async function startBrowser({ width, height, extra = [] }) {
  const profile = mkdtempSync(join(tmpdir(), "ptet-web-"));
  const context = await chromium.launchPersistentContext(profile, {
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    viewport: { width, height },
    acceptDownloads: true,
    args: [
      "--no-sandbox", // its sandbox does not run as root, as in containers
      "--use-gl=angle",
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
      "--disable-dev-shm-usage",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      ...extra,
    ],
  });
  const page = context.pages()[0] ?? (await context.newPage());
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) console.log(`  browser: ${message.text()}`);
  });
  page.on("pageerror", (error) => console.log(`  browser: ${error.stack}`));
  return {
    page,
    close: async () => {
      await context.close();
      rmSync(profile, { recursive: true, force: true });
    },
  };
}

/** Waits until the page shows what was asked of it last, or says why it cannot. */
export async function settled(page, seconds = 60) {
  await page.waitForFunction(() => ["done", "failed"].includes(document.body.dataset.state), null, {
    timeout: 1000 * seconds,
  });
}

// A takt in another process, a real Chromium before it, and what tests ask of both.
import { spawn } from "node:child_process";
import { createRequire } from "node:module";
import { once } from "node:events";
import { existsSync, readFileSync } from "node:fs";
import { createInterface } from "node:readline";

const require = createRequire(
  new URL("../../panel/package.json", import.meta.url),
);
const { chromium } = require("playwright-core");
export const AXE = require.resolve("axe-core/axe.min.js");
export const SCENARIO = "scenarios/touch.json";

const takt = process.env.TAKT ?? "build/release/tools/takt";
const BROWSERS = [
  "/usr/bin/chromium",
  "/usr/bin/chromium-browser",
  "/usr/bin/google-chrome",
];

/** A running takt; its address is what it prints. */
export class Takt {
  static #running = new Set();
  /** Ends what a failed test has left running: this process would wait for it. */
  static killAll() {
    for (const one of Takt.#running) one.process.kill("SIGKILL");
  }

  static async start(...args) {
    const one = new Takt();
    one.process = spawn(takt, args, { stdio: ["ignore", "pipe", "pipe"] });
    Takt.#running.add(one);
    one.process.once("exit", () => Takt.#running.delete(one));
    one.output = "";
    one.process.stdout.on("data", (text) => {
      one.output += text;
    });
    one.url = await new Promise((resolve, reject) => {
      const lines = createInterface({ input: one.process.stderr });
      let all = "";
      lines.on("line", (line) => {
        all += `${line}\n`;
        const found = /page: (http:\S+)/.exec(line);
        if (found) resolve(found[1]);
      });
      one.process.once("exit", () =>
        reject(new Error(`takt ${args.join(" ")} has ended:\n${all}`)),
      );
    });
    one.origin = new URL(one.url).origin;
    one.token =
      new URLSearchParams(new URL(one.url).hash.slice(1)).get("token") ?? "";
    return one;
  }

  async ask(method, path, body, headers = {}) {
    if (this.token) headers.Authorization = `Bearer ${this.token}`;
    if (body !== undefined) headers["Content-Type"] = "application/json";
    const answer = await fetch(this.origin + path, {
      method,
      headers,
      body: body === undefined ? undefined : JSON.stringify(body),
    });
    return answer.json();
  }

  async arm() {
    return (await this.ask("GET", "/v1/arms/arm")).state;
  }
  get port() {
    return new URL(this.origin).port;
  }

  async end() {
    if (this.process.exitCode !== null) return this.process.exitCode;
    this.process.kill("SIGINT");
    const [code] = await once(this.process, "exit");
    return code;
  }
}

export async function launch() {
  const executablePath = BROWSERS.find(existsSync);
  if (!executablePath)
    throw new Error(
      `no Chromium at ${BROWSERS.join(", ")}: apt-get install chromium`,
    );
  // Software rendering, as a machine without a graphics card has it.
  return chromium.launch({
    executablePath,
    args: ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader"],
  });
}

/** A page before a takt, with all that went wrong in it: errors of scripts and console, violations of the policy. */
export async function open(browser, url, options = {}) {
  const context = await browser.newContext({
    viewport: { width: 800, height: 460 },
    ...options,
  });
  const page = await context.newPage();
  page.problems = [];
  page.on("pageerror", (error) => page.problems.push(error.message));
  page.on("console", (message) => {
    const { url } = message.location();
    // A net may be forgotten between its event and the question what it is: the browser calls that an error.
    const forgotten =
      /\/v1\/nets\/\d+(\/graph|\/report)?$/.test(url) &&
      message.text().includes("404");
    if (message.type() === "error" && !forgotten)
      page.problems.push(`${message.text()} (${url})`);
  });
  await page.addInitScript(() =>
    document.addEventListener("securitypolicyviolation", (event) =>
      console.error(`policy: ${event.violatedDirective} ${event.blockedURI}`),
    ),
  );
  await page.goto(url);
  return page;
}

/** Open, and shown all that the server has. */
export async function ready(browser, url, options) {
  const page = await open(browser, url, options);
  await page
    .locator("#reality")
    .filter({ hasText: /SIM|EMULATED|HARDWARE/ })
    .waitFor();
  await page
    .locator("#side select option")
    .first()
    .waitFor({ state: "attached" });
  return page;
}

/** Until a condition holds; an error says what it last was. */
export async function until(what, look, holds, seconds = 10) {
  const end = Date.now() + 1000 * seconds;
  let value;
  do {
    value = await look();
    if (holds(value)) return value;
    await new Promise((resolve) => setTimeout(resolve, 20));
  } while (Date.now() < end);
  throw new Error(`${what}: still ${JSON.stringify(value)} after ${seconds} s`);
}

/** Whether an arm stands, by two looks at its set point, which may change in its last bits. */
export async function stands(server) {
  const { q_commanded: before } = await server.arm();
  await new Promise((resolve) => setTimeout(resolve, 60));
  const { q_commanded: after } = await server.arm();
  return before.every((one, i) => Math.abs(one - after[i]) < 1e-9);
}

export const close = (page) => page.context().close();
/** Makes the page the one that commands. */
export async function take(page) {
  await page.getByRole("button", { name: /Take control|Take over/ }).click();
  await page.getByRole("button", { name: "Release control" }).waitFor();
}
/**
 * Does something, and waits until the arm has moved by it. On a busy machine it may rest again soon: a page that is
 * held up lets go.
 */
export async function moves(server, act) {
  const { q_commanded: before } = await server.arm();
  await act();
  await until(
    "the arm moves",
    async () => (await server.arm()).q_commanded,
    (now) => now.some((one, i) => Math.abs(one - before[i]) > 1e-5),
  );
}
export const rests = (server) =>
  until(
    "the arm rests",
    () => stands(server),
    (value) => value,
    3,
  );

/** WCAG 2.1 A and AA, by axe-core. */
export async function barriers(page) {
  const source = readFileSync(AXE, "utf8");
  // By the debugger's way, which the policy of the page does not forbid.
  const session = await page.context().newCDPSession(page);
  await session.send("Runtime.evaluate", { expression: source });
  const expression = `axe
    .run(document, { runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"] })
    .then(({ violations }) => violations.map((one) => one.id + ": " + one.nodes.map((node) => node.target).join(" ")))
    .then(JSON.stringify)`;
  const { result } = await session.send("Runtime.evaluate", {
    expression,
    awaitPromise: true,
  });
  return JSON.parse(result.value);
}

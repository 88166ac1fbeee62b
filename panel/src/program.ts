// The program that commands the cell: its tree with the steps that run, and what an operator may ask of it.
import { wordsOf, type LogEntry, type Program, type Step } from "./api";
import { h, setText, slider } from "./dom";
import type { Link } from "./link";

interface Row {
  element: HTMLElement;
  name: string;
  children: Row[];
}

const WORDS: Record<Program["state"], string> = {
  "awaits start": "Ready: nothing has moved yet. Start begins.",
  runs: "Runs",
  paused: "Paused: at rest on its path",
  "awaits step": "Waits before the next step: the time stands",
  ended: "Ended",
};

export class ProgramPanel {
  readonly panel = h("div", { class: "program" });
  private readonly tree = h("ul", { class: "tree", "aria-label": "Steps of the program" });
  private readonly said = h("p", { class: "said", role: "status" });
  private readonly time = h("p", { class: "quiet" });
  private readonly result = h("div", { class: "result" });
  private readonly buttons: Record<"start" | "pause" | "step" | "cancel", HTMLButtonElement>;
  private readonly speed = slider(
    "Speed",
    { min: 0, max: 1, step: 0.05, value: 1 },
    (value) => `${Math.round(100 * value)} %`,
    (share) => void this.ask("PUT", "speed", { share }),
  );
  private roots: Row[] = [];
  private began = 0;
  private time_s = 0;
  private asked: Promise<void> = Promise.resolve();
  private running: string[] = [];

  constructor(private readonly link: Link) {
    const button = (what: string, text: string, keys: string): HTMLButtonElement =>
      h(
        "button",
        {
          type: "button",
          "aria-keyshortcuts": keys,
          title: `${text} (${keys})`,
          click: () => void this.ask("POST", what, {}),
        },
        text,
      );
    this.buttons = {
      start: button("start", "Start", "F8"),
      pause: button("pause", "Pause", "F9"),
      step: button("step", "Step", "F10"),
      cancel: button("cancel", "Cancel", ""),
    };
    this.buttons.cancel.removeAttribute("aria-keyshortcuts");
    this.buttons.cancel.title = "Ends in order";
    this.panel.append(
      h("div", { class: "fields", role: "toolbar", "aria-label": "Program" }, ...Object.values(this.buttons)),
      this.speed.label,
      this.said,
      this.time,
      this.result,
      this.tree,
    );
    addEventListener("keydown", (event) => this.key(event));
  }

  async load(): Promise<void> {
    const { steps } = await this.link.ask<{ steps: Step[] }>("GET", "/v1/program/tree");
    this.roots = steps.map((step) => row(step));
    this.tree.replaceChildren(...this.roots.map((one) => one.element));
    this.running = [];
  }

  show(program: Program, time_s: number): void {
    this.time_s = time_s;
    setText(
      this.said,
      program.state === "awaits step" && program.next.name
        ? `Waits before '${program.next.name}': the time stands`
        : WORDS[program.state],
    );
    const isOver = program.state === "ended";
    const observes = this.link.role === "observer";
    setText(this.buttons.start, program.state === "awaits start" ? "Start" : "Continue");
    this.buttons.start.disabled = observes || isOver || (program.state === "runs" && !program.single);
    this.buttons.pause.disabled = observes || isOver || program.state === "awaits start" || program.state === "paused";
    this.buttons.step.disabled = observes || isOver || !program.steps;
    this.buttons.cancel.disabled = observes || isOver || program.cancelled;
    this.speed.input.disabled = observes || isOver;
    this.speed.show(program.speed);
    setText(
      this.time,
      program.planned_s > 0 ? `${time_s.toFixed(1)} s of about ${program.planned_s.toFixed(1)} s predicted` : "",
    );
    this.showRunning(program.running);
    const changed = program.next.changed.map((one) => h("p", { class: "variable" }, one));
    const findings = program.findings.map((one) => h("li", {}, one));
    const verdict = isOver
      ? [
          h("p", { class: "verdict", "data-verdict": program.verdict }, program.verdict),
          ...(findings.length ? [h("ul", {}, ...findings)] : []),
        ]
      : [];
    if (this.result.textContent !== [...changed, ...verdict].map((one) => one.textContent).join(""))
      this.result.replaceChildren(...changed, ...verdict);
  }

  /** Marks how steps ended. */
  read(entries: LogEntry[]): void {
    for (const { source, name, step } of entries) {
      if (source !== "program" || !["begin", "end", "failed"].includes(name)) continue;
      const found = this.find(step);
      if (found && name !== "begin") found.element.dataset["how"] = name;
    }
  }

  /** One after the other, in the order in which somebody asked: a pause that overtook its start would be lost. */
  private ask(method: string, what: string, body: object): Promise<void> {
    this.asked = this.asked.then(() => this.askNow(method, what, body));
    return this.asked;
  }

  private async askNow(method: string, what: string, body: object): Promise<void> {
    try {
      this.show(await this.link.ask<Program>(method, `/v1/program/${what}`, body), this.time_s);
    } catch (error) {
      setText(this.said, wordsOf(error));
    }
  }

  private key(event: KeyboardEvent): void {
    const button = { F8: this.buttons.start, F9: this.buttons.pause, F10: this.buttons.step }[event.key];
    if (!button || !button.isConnected || button.disabled || event.repeat) return;
    event.preventDefault();
    button.click();
  }

  private showRunning(paths: string[]): void {
    if (paths.join("\n") === this.running.join("\n")) return;
    this.running = paths;
    for (const marked of this.tree.querySelectorAll("[aria-current]")) marked.removeAttribute("aria-current");
    for (const path of paths) {
      const found = this.find(path);
      if (!found) continue;
      found.element.setAttribute("aria-current", "step");
      delete found.element.dataset["how"];
      if (performance.now() - this.began > 300) found.element.firstElementChild?.scrollIntoView({ block: "nearest" });
    }
    this.began = performance.now();
  }

  /** "sort / for_each (2) / grip": names from the root on, of those that have one; rounds in brackets. */
  private find(path: string): Row | undefined {
    let level = this.roots;
    let found: Row | undefined;
    for (const part of path.split(" / ")) {
      const name = part.replace(/ \(\d+\)$/, "");
      const next = search(level, name) ?? search(level, part);
      if (!next) return found;
      found = next;
      level = next.children;
    }
    return found;
  }
}

/** The nearest row of this name, through rows that have none. */
function search(rows: Row[], name: string): Row | undefined {
  return (
    rows.find((one) => one.name === name) ??
    rows.map((one) => search(one.children, name)).find((one) => one !== undefined)
  );
}

function row(step: Step): Row {
  const children = step.steps.map((one) => row(one));
  const label = h("span", { class: "step" }, h("span", { class: "kind" }, step.do), step.name);
  const element = h(
    "li",
    { title: step.pointer },
    label,
    ...(children.length ? [h("ul", {}, ...children.map((one) => one.element))] : []),
  );
  return { element, name: step.name || step.do, children };
}

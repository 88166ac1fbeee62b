// The page: what is always visible, the 3D view, the nets, the events.
import "./panel.css";
import { Link, type CellEvent, type Json } from "./link";
import { View3d } from "./view3d";

const link = new Link();
const view = new View3d(link);
const by = (id: string): HTMLElement => document.getElementById(id)!;
const MOST_EVENTS = 500;

function line(text: string, quiet = false): HTMLLIElement {
  const item = document.createElement("li");
  item.textContent = text;
  if (quiet) item.className = "quiet";
  return item;
}

async function showNets(): Promise<void> {
  const { nets } = await link.ask("GET", "/v1/nets");
  const items: HTMLLIElement[] = [];
  for (const net of nets as Json[]) {
    items.push(line(`${net.net} ${net.name}: ${net.state}`));
    if (net.state !== "Rejected") continue;
    const { diagnostics } = await link.ask("GET", `/v1/nets/${net.net}`);
    for (const why of diagnostics) items.push(line(`${why.pointer ?? ""} ${why.message ?? ""} ${why.hint ?? ""}`, true));
  }
  by("nets").replaceChildren(...(items.length ? items : [line("No net is loaded", true)]));
}

function showEvents(events: CellEvent[]): void {
  for (const event of events.slice(-MOST_EVENTS)) {
    const time = (event.cycle * link.period_s).toFixed(3);
    by("events").prepend(line(`${time} s  net ${event.net}: ${event.state ?? event.kind} ${event.text}`));
  }
  while (by("events").childElementCount > MOST_EVENTS) by("events").lastElementChild!.remove();
  showNets().catch(showProblem);
}

function showProblem(problem: unknown): void {
  by("events").prepend(line(`Problem: ${problem instanceof Error ? problem.message : String(problem)}`));
}

async function showState(): Promise<void> {
  const state = await link.ask("GET", "/v1/state");
  by("title").textContent = state.title;
  by("holder").textContent = state.holder === 0 ? "nobody commands" : `holder: fence ${state.holder}`;
}

let loaded = false;
link.onPoses = (poses) => view.show(poses);
link.onEvents = showEvents;
link.onState = (open) => {
  if (!open || loaded) return;
  loaded = true;
  view.load().catch((problem) => { loaded = false; showProblem(problem); });
  showNets().catch(showProblem);
};
by("view").append(view.element);
by("stop").onclick = () => { link.ask("POST", "/v1/stop", {}).catch(showProblem); };
by("theme").onclick = () => {
  const root = document.documentElement;
  by("theme").textContent = root.dataset.theme ?? "dark";
  root.dataset.theme = root.dataset.theme === "light" ? "dark" : "light";
};
setInterval(() => {
  const age = performance.now() - link.heard;
  by("age").textContent = link.heard === 0 ? "not connected" : `link ${Math.round(age / 100) / 10} s`;
  by("age").toggleAttribute("data-old", link.heard === 0 || age > 1000);
  showState().catch(() => {});
}, 500);
void link.connect();

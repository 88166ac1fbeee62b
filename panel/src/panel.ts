// The page: puts its parts together and tells them what the server says.
import "./panel.css";
import {
  Problem,
  wordsOf,
  type CellEvent,
  type Diagnostic,
  type Graph,
  type LogEntry,
  type Program,
  type State,
} from "./api";
import { Cameras } from "./cameras";
import { byId, setText } from "./dom";
import { Events } from "./events";
import { Faults } from "./faults";
import { JogPanel } from "./jog_panel";
import { Link } from "./link";
import { Nets } from "./nets";
import { Plots } from "./plots";
import { ProgramPanel } from "./program";
import { Station, type LayoutFile } from "./station";
import { StatusBar } from "./statusbar";
import { Tabs, type Tab } from "./tabs";
import { TimeAxis } from "./time_axis";
import { Timeline } from "./timeline";
import { startTheme } from "./theme";
import { setToken, takeTokenFromAddress } from "./token";
import { View3d } from "./view3d";

const STATE_EVERY_MS = 300;

class Panel {
  private readonly link = new Link();
  private readonly axis = new TimeAxis();
  private readonly bar = new StatusBar(this.link, (text) => this.notice(text));
  private readonly view = new View3d(this.link);
  private readonly program = new ProgramPanel(this.link);
  private readonly jog = new JogPanel(this.link);
  private readonly nets = new Nets(this.link);
  private readonly cameras = new Cameras(this.link);
  private readonly faults = new Faults(
    () => this.link.period_s,
    (count) => [this.side, ...this.laidOut].forEach((tabs) => tabs.count("faults", count)),
  );
  private readonly plots = new Plots(this.link, this.axis);
  private readonly timeline = new Timeline(this.axis);
  private readonly events = new Events();
  private readonly operation: Tab[] = [
    { id: "jog", title: "Jog", panel: this.jog.panel },
    { id: "program", title: "Program", panel: this.program.panel },
    { id: "nets", title: "Nets", panel: this.nets.panel, shown: (visible) => this.nets.show(visible) },
    { id: "cameras", title: "Cameras", panel: this.cameras.panel, shown: (visible) => this.cameras.show(visible) },
    { id: "faults", title: "Faults", panel: this.faults.panel },
  ];
  private readonly time: Tab[] = [
    { id: "plots", title: "Plots", panel: this.plots.panel },
    { id: "timeline", title: "Time line", panel: this.timeline.panel },
    { id: "events", title: "Events", panel: this.events.panel },
  ];
  private readonly side = new Tabs("Operation", this.operation);
  private readonly below = new Tabs("Time", this.time);
  /** Of a layout, in place of the two above. */
  private laidOut: Tabs[] = [];
  private station: Station | null = null;
  private loaded = false;
  private nextEntry = 1;
  private hideNotice = 0;

  constructor() {
    byId("view").append(this.view.element);
    byId("side").append(this.side.element);
    byId("below").append(this.below.element);
    startTheme(byId("theme"), (colors) => this.view.theme(colors));
    this.link.opened.on(({ restarted }) => this.opened(restarted));
    this.link.lost.on(() =>
      this.notice("The server cannot be reached. The page connects again by itself; nothing begins by itself."),
    );
    this.link.needsToken.on((why) => this.askToken(why));
    this.link.events.on((events) => this.hear(events));
    this.link.poses.on((poses) => this.axis.advance(poses.time_s));
  }

  start(): void {
    takeTokenFromAddress();
    addEventListener("hashchange", () => {
      takeTokenFromAddress();
      location.reload();
    });
    void this.link.connect();
    setInterval(() => void this.poll(), STATE_EVERY_MS);
  }

  private opened(restarted: boolean): void {
    this.notice(restarted ? "The server was started anew: the page shows the new run." : "");
    if (restarted) this.forget();
    if (restarted || !this.loaded) void this.load();
  }

  private forget(): void {
    this.nextEntry = 1;
    for (const part of [this.nets, this.faults, this.timeline, this.events]) part.clear();
  }

  private async load(): Promise<void> {
    this.loaded = true;
    try {
      const state = await this.link.ask<State>("GET", "/v1/state");
      this.bar.show(state);
      const scene = await this.view.load();
      this.cameras.load(scene);
      await this.plots.load(scene);
      await this.jog.load(scene);
      if (state.program) {
        await this.program.load();
        this.side.show("program");
      }
      await this.layOut();
    } catch (error) {
      this.loaded = false;
      this.notice(wordsOf(error));
    }
  }

  /** The panes of the layout file beside the scenario, if there is one; a broken one is reported, and nothing is lost. */
  private async layOut(): Promise<void> {
    if (this.station) return;
    const { layout, diagnostics } = await this.link.ask<{ layout: LayoutFile | null; diagnostics: Diagnostic[] }>(
      "GET",
      "/v1/layout",
    );
    if (diagnostics.length > 0)
      this.notice(new Problem(422, "The layout file is broken, so the usual page is shown", diagnostics).words, true);
    if (!layout) return;
    const all = [...this.operation, ...this.time];
    this.station = new Station(this.link, layout, {
      view3d: this.view.element,
      tabs: (names) => {
        const tabs = new Tabs(
          "More",
          names.flatMap((name) => all.filter((tab) => tab.id === name)),
        );
        this.laidOut.push(tabs);
        return tabs.element;
      },
    });
    const main = document.querySelector("main");
    main?.classList.add("laid-out");
    main?.append(this.station.element);
    for (const tabs of this.laidOut) tabs.show("program");
  }

  private async poll(): Promise<void> {
    if (!this.link.open || document.hidden) return;
    try {
      const state = await this.link.ask<State>("GET", "/v1/state");
      this.bar.show(state);
      this.faults.show(state.faults);
      this.jog.show(state.holder, state.program);
      this.station?.show(state.holder);
      if (state.program) await this.pollProgram(state);
      else await this.nets.refreshList();
    } catch (error) {
      if (!(error instanceof TypeError)) this.notice(wordsOf(error)); // TypeError: not reachable, which the link says
    }
  }

  private async pollProgram(state: State): Promise<void> {
    const { entries, next } = await this.link.ask<{ entries: LogEntry[]; next: number }>(
      "GET",
      `/v1/program/log?from=${this.nextEntry}`,
    );
    this.nextEntry = next;
    for (const part of [this.program, this.faults, this.timeline, this.events]) part.read(entries);
    this.station?.read(entries);
    this.program.show(await this.link.ask<Program>("GET", "/v1/program"), state.time_s);
  }

  private hear(events: CellEvent[]): void {
    this.events.hear(events, this.link.period_s);
    this.timeline.hear(events, this.link.period_s);
    this.faults.hear(events);
    this.nets.hear(events);
    const started = events.findLast((event) => event.kind === "state");
    if (started?.state === "Running")
      this.link
        .ask<Graph>("GET", `/v1/nets/${started.net}/graph`)
        .then((graph) => this.plots.offerNet(graph))
        .catch(() => this.plots.offerNet(null));
  }

  /** @param stays  until it is replaced */
  private notice(text: string, stays = false): void {
    const notice = byId("notice");
    notice.hidden = text === "";
    setText(notice, text);
    clearTimeout(this.hideNotice);
    if (text && this.link.open && !stays)
      this.hideNotice = window.setTimeout(() => {
        notice.hidden = true;
      }, 8000);
  }

  private askToken(why: string): void {
    const dialog = byId<HTMLDialogElement>("ask-token");
    setText(byId("token-why"), why);
    dialog.addEventListener("cancel", (event) => event.preventDefault());
    dialog.onclose = () => {
      const input = byId<HTMLInputElement>("token");
      setToken(input.value.trim());
      input.value = "";
      void this.link.connect();
    };
    if (!dialog.open) dialog.showModal();
  }
}

new Panel().start();

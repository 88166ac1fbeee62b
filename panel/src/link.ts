// The one connection with the server: requests, the stream, the lease. It reconnects by itself and moves nothing by
// itself.
import { Problem, type CellEvent } from "./api";
import { decode, type Entry, type Picture, type Poses } from "./frames";
import { Signal } from "./signal";
import { token } from "./token";

export type Message = Record<string, unknown> & { op: string };
/** What is watched: of an arm, a sensor, a channel, a net, or all poses. */
export type Watched =
  | { arm: string; value: "q_measured" | "q_commanded" | "dq_measured" | "tau_measured" }
  | { sensor: string }
  | { channel: string }
  | { net: number; port: string }
  | { poses: true };
export interface Seen {
  camera: string;
  width: number;
  height: number;
}
interface Monitor {
  message: Message;
  take: (entry: Entry) => void;
  see?: (picture: Picture) => void;
  refused: (why: string) => void;
}

const RECONNECT_MS = 1000;
const RENEW_MS = 250;
/** Of silence, after which somebody else may command. An arm that is jogged rests long before. */
const LEASE_S = 3;

export class Link {
  fence = 0;
  period_s = 0.001;
  role: "observer" | "operator" = "operator";
  /** When the server was heard last, ms of performance.now(); 0: not yet. */
  heard = 0;
  open = false;
  readonly opened = new Signal<{ restarted: boolean }>();
  readonly lost = new Signal<void>();
  readonly needsToken = new Signal<string>();
  readonly events = new Signal<CellEvent[]>();
  readonly poses = new Signal<Poses>();
  readonly messages = new Signal<Message>();
  readonly leaseChanged = new Signal<void>();
  private socket: WebSocket | null = null;
  private next = 1;
  private lastCycle = 0;
  private lastId = 0;
  private readonly monitors = new Map<number, Monitor>();

  /** A request. Throws Problem for what the server refuses, TypeError when it cannot be reached. */
  async ask<T>(method: string, path: string, body?: object): Promise<T> {
    const answer = await this.request(method, path, body);
    return answer.json() as Promise<T>;
  }

  async bytes(path: string): Promise<ArrayBuffer> {
    return (await this.request("GET", path)).arrayBuffer();
  }

  async connect(): Promise<void> {
    try {
      const { ticket } = await this.ask<{ ticket: string }>("POST", "/v1/tickets", {});
      const scheme = location.protocol === "https:" ? "wss" : "ws";
      const socket = new WebSocket(
        `${scheme}://${location.host}/v1/stream?ticket=${encodeURIComponent(ticket)}`,
        "takt.v1",
      );
      socket.binaryType = "arraybuffer";
      this.socket = socket;
      socket.onmessage = (message: MessageEvent<string | ArrayBuffer>) => this.received(message.data);
      socket.onclose = (event) => {
        const resume = /^resume (\d+)$/.exec(event.reason);
        if (event.code === 4008 && resume) this.next = Number(resume[1]);
        this.closed();
      };
    } catch (error) {
      if (error instanceof Problem && error.status === 401)
        this.needsToken.emit(token() ? "The server does not know this token." : "The server asks for a token.");
      else this.closed();
    }
  }

  send(message: Message): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** A value, every so many seconds; it goes on after a reconnect. @return what ends it */
  monitor(
    what: Watched,
    every_s: number,
    take: (entry: Entry) => void,
    refused: (why: string) => void = () => {},
  ): () => void {
    const id = ++this.lastId;
    const message = { op: "monitor", id, every: Math.max(1, Math.round(every_s / this.period_s)), ...what };
    this.monitors.set(id, { message, take, refused });
    this.send(message);
    return () => {
      if (this.monitors.delete(id)) this.send({ op: "unmonitor", id });
    };
  }

  /** The pictures of a camera, as often as the server and the page manage, at most every so many seconds. */
  watchCamera(
    what: Seen,
    every_s: number,
    see: (picture: Picture) => void,
    refused: (why: string) => void = () => {},
  ): () => void {
    const id = ++this.lastId;
    const message = { op: "monitor", id, every: Math.max(1, Math.round(every_s / this.period_s)), ...what };
    this.monitors.set(id, { message, take: () => {}, see, refused });
    this.send(message);
    return () => {
      if (this.monitors.delete(id)) this.send({ op: "unmonitor", id });
    };
  }

  /** The newest cycle that the page has heard of. */
  get cycle(): number {
    return this.lastCycle;
  }

  async takeLease(takeOver: boolean): Promise<void> {
    const cycles = Math.round(LEASE_S / this.period_s);
    this.fence = (await this.ask<{ fence: number }>("POST", "/v1/lease", { cycles, take_over: takeOver })).fence;
    this.leaseChanged.emit();
    this.renewLater(this.fence);
  }

  async releaseLease(): Promise<void> {
    try {
      await this.ask("DELETE", "/v1/lease", {});
    } finally {
      this.loseLease();
    }
  }

  private async request(method: string, path: string, body?: object): Promise<Response> {
    const headers: Record<string, string> = {};
    if (body !== undefined) headers["Content-Type"] = "application/json";
    if (token()) headers["Authorization"] = `Bearer ${token()}`;
    if (this.fence) headers["Takt-Fence"] = String(this.fence);
    const answer = await fetch(path, {
      method,
      headers,
      body: body === undefined ? undefined : JSON.stringify(body),
      cache: "no-store",
      referrerPolicy: "no-referrer",
    });
    if (answer.ok) {
      this.heard = performance.now();
      return answer;
    }
    const isJson = (answer.headers.get("Content-Type") ?? "").includes("json");
    const problem = isJson ? await answer.json() : {};
    throw new Problem(
      answer.status,
      problem.detail ?? `the server answered ${answer.status}`,
      problem.diagnostics ?? [],
    );
  }

  private renewLater(fence: number): void {
    setTimeout(async () => {
      if (this.fence !== fence) return;
      try {
        await this.ask("PUT", "/v1/lease", {});
        this.renewLater(fence);
      } catch {
        if (this.fence === fence) this.loseLease();
      }
    }, RENEW_MS);
  }

  private loseLease(): void {
    this.fence = 0;
    this.leaseChanged.emit();
  }

  private received(data: string | ArrayBuffer): void {
    this.heard = performance.now();
    if (typeof data !== "string") return this.receivedFrame(data);
    const message = JSON.parse(data) as Message;
    switch (message.op) {
      case "hello":
        return this.greeted(message as Message & { role: Link["role"]; period_s: number; cycle: number; next: number });
      case "events":
        this.next = message["next"] as number;
        return this.events.emit(message["events"] as CellEvent[]);
      case "ended":
        this.monitors.delete(message["id"] as number);
        break;
      case "problem":
        if (message["for"] === "monitor") this.refused(message);
        break;
    }
    this.messages.emit(message);
  }

  private refused(message: Message): void {
    const monitor = this.monitors.get(message["id"] as number);
    this.monitors.delete(message["id"] as number);
    monitor?.refused(
      new Problem(
        message["status"] as number,
        message["detail"] as string,
        (message["diagnostics"] ?? []) as Problem["diagnostics"],
      ).words,
    );
  }

  private receivedFrame(data: ArrayBuffer): void {
    const frame = decode(data);
    this.lastCycle = Math.max(this.lastCycle, frame.cycle);
    if (frame.kind === "poses") this.poses.emit(frame);
    else if (frame.kind === "picture") this.monitors.get(frame.id)?.see?.(frame);
    else for (const entry of frame.entries) this.monitors.get(entry.id)?.take(entry);
    this.send({ op: "ack", frame: frame.frame });
  }

  private greeted(hello: { role: Link["role"]; period_s: number; cycle: number; next: number }): void {
    // A cell whose time has gone back is another one: numbers of nets and events begin anew.
    const restarted = hello.cycle < this.lastCycle || hello.next < this.next;
    if (restarted) {
      this.next = 1;
      for (const [id, { message }] of this.monitors) if ("net" in message) this.monitors.delete(id);
      if (this.fence) this.loseLease();
    }
    this.lastCycle = hello.cycle;
    this.period_s = hello.period_s;
    this.role = hello.role;
    this.open = true;
    this.send({ op: "events", from: this.next });
    for (const one of this.monitors.values()) this.send(one.message);
    this.opened.emit({ restarted });
  }

  private closed(): void {
    this.socket = null;
    this.open = false;
    this.lost.emit();
    setTimeout(() => void this.connect(), RECONNECT_MS);
  }
}

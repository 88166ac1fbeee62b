// The one connection with the server: requests, the stream, the lease. It reconnects by itself and moves nothing by itself.
import { decode, type Entry, type Poses } from "./frames";

export interface CellEvent { sequence: number; cycle: number; kind: string; net: number; request: number; cause: string; text: string; state?: string }
export interface Diagnostic { code?: string; pointer?: string; message?: string; hint?: string }
export class Problem extends Error {
  constructor(readonly status: number, detail: string, readonly diagnostics: Diagnostic[]) { super(detail); }
}
// eslint-disable-next-line @typescript-eslint/no-explicit-any
export type Json = any;

export class Link {
  fence = 0;
  period_s = 0.001;
  realtime = true;
  /** When the last message came, ms of performance.now(); 0: not yet. */
  heard = 0;
  onState: (open: boolean) => void = () => {};
  onEvents: (events: CellEvent[]) => void = () => {};
  onPoses: (poses: Poses) => void = () => {};
  onMessage: (message: Json) => void = () => {};
  onLease: () => void = () => {};
  private socket: WebSocket | null = null;
  private next = 1;
  private lastId = 0;
  private readonly monitors = new Map<number, { message: Json; take: (entry: Entry) => void }>();
  private token = sessionStorage.getItem("takt.token") ?? "";

  setToken(token: string): void {
    this.token = token;
    sessionStorage.setItem("takt.token", token);
  }

  async ask(method: string, path: string, body?: Json): Promise<Json> {
    const headers: Record<string, string> = {};
    if (body !== undefined) headers["Content-Type"] = "application/json";
    if (this.token) headers["Authorization"] = `Bearer ${this.token}`;
    if (this.fence) headers["Takt-Fence"] = String(this.fence);
    const answer = await fetch(path, { method, headers, body: body === undefined ? undefined : JSON.stringify(body), cache: "no-store" });
    const type = answer.headers.get("Content-Type") ?? "";
    if (!answer.ok) {
      const json = type.includes("json") ? await answer.json() : {};
      throw new Problem(answer.status, json.detail ?? `the server answered ${answer.status}`, json.diagnostics ?? []);
    }
    return type.includes("json") ? answer.json() : answer.arrayBuffer();
  }

  async connect(): Promise<void> {
    try {
      const { ticket } = await this.ask("POST", "/v1/tickets", {});
      const scheme = location.protocol === "https:" ? "wss" : "ws";
      const socket = new WebSocket(`${scheme}://${location.host}/v1/stream?ticket=${encodeURIComponent(ticket)}`, "takt.v1");
      socket.binaryType = "arraybuffer";
      this.socket = socket;
      socket.onmessage = (message) => this.received(message.data);
      socket.onclose = (event) => {
        const resume = /^resume (\d+)$/.exec(event.reason);
        if (event.code === 4008 && resume) this.next = Number(resume[1]);
        this.closed();
      };
    } catch (error) {
      if (error instanceof Problem && error.status === 401) this.onMessage({ op: "token_needed" });
      this.closed();
    }
  }

  send(message: Json): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** A value at a rate. @return what ends it */
  monitor(what: Json, every: number, take: (entry: Entry) => void): () => void {
    const id = ++this.lastId;
    const message = { op: "monitor", id, every, ...what };
    this.monitors.set(id, { message, take });
    this.send(message);
    return () => {
      this.monitors.delete(id);
      this.send({ op: "unmonitor", id });
    };
  }

  async takeLease(takeOver: boolean): Promise<void> {
    this.fence = (await this.ask("POST", "/v1/lease", { cycles: Math.round(1 / this.period_s), take_over: takeOver })).fence;
    this.onLease();
    this.renew(this.fence);
  }

  async releaseLease(): Promise<void> {
    await this.ask("DELETE", "/v1/lease", {});
    this.fence = 0;
    this.onLease();
  }

  private renew(fence: number): void {
    setTimeout(async () => {
      if (this.fence !== fence) return;
      try {
        await this.ask("PUT", "/v1/lease", {});
        this.renew(fence);
      } catch {
        if (this.fence === fence) this.fence = 0;
        this.onLease();
      }
    }, 250);
  }

  private received(data: string | ArrayBuffer): void {
    this.heard = performance.now();
    if (typeof data !== "string") {
      const frame = decode(data);
      if (frame.kind === "poses") this.onPoses(frame);
      else for (const entry of frame.entries) this.monitors.get(entry.id)?.take(entry);
      this.send({ op: "ack", frame: frame.frame });
      return;
    }
    const message = JSON.parse(data);
    if (message.op === "hello") {
      this.period_s = message.period_s;
      this.realtime = message.realtime;
      this.send({ op: "events", from: this.next });
      for (const one of this.monitors.values()) this.send(one.message);
      this.onState(true);
    } else if (message.op === "events") {
      this.next = message.next;
      this.onEvents(message.events);
      return;
    }
    this.onMessage(message);
  }

  private closed(): void {
    this.socket = null;
    this.onState(false);
    setTimeout(() => void this.connect(), 1000);
  }
}

// Channels that the page writes. Of each the newest value counts: what waits for an answer is replaced, never queued,
// and a value that comes late through a frozen network is refused by the server.
import { wordsOf } from "./api";
import type { Link } from "./link";
import { Signal } from "./signal";

const LATE_S = 0.25;

export class Channels {
  readonly refused = new Signal<string>();
  private readonly wanted = new Map<string, unknown>();
  private readonly busy = new Set<string>();

  constructor(private readonly link: Link) {}

  write(channel: string, value: unknown): void {
    this.wanted.set(channel, value);
    if (!this.busy.has(channel)) void this.send(channel);
  }

  private async send(channel: string): Promise<void> {
    this.busy.add(channel);
    while (this.wanted.has(channel)) {
      const value = this.wanted.get(channel);
      this.wanted.delete(channel);
      const expires_at_cycle = this.link.cycle + Math.round(LATE_S / this.link.period_s);
      try {
        await this.link.ask("PUT", `/v1/channels/${encodeURIComponent(channel)}`, { value, expires_at_cycle });
      } catch (error) {
        this.wanted.delete(channel);
        this.refused.emit(wordsOf(error));
      }
    }
    this.busy.delete(channel);
  }
}

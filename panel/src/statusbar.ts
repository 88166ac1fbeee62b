// What is always visible: what moves, the age of the link, real-time health, who commands, STOP.
import type { State } from "./api";
import { wordsOf } from "./api";
import { byId, setText } from "./dom";
import type { Link } from "./link";

const OLD_MS = 1000;
const REALITY: Record<State["reality"], string> = {
  SIM: "Everything is simulated",
  EMULATED: "Drivers of real devices, against emulated controllers",
  HARDWARE: "Something real moves",
};

export class StatusBar {
  private readonly say: (text: string) => void;

  constructor(
    private readonly link: Link,
    say: (text: string) => void,
  ) {
    this.say = say;
    byId("stop").addEventListener("click", () => void this.stop());
    // Wherever the focus is, and before anything else hears of the key.
    addEventListener(
      "keydown",
      (event) => {
        if (event.key !== "Escape" || event.repeat) return;
        event.preventDefault();
        void this.stop();
      },
      { capture: true },
    );
    setInterval(() => this.showAge(), 200);
  }

  show(state: State): void {
    setText(byId("title"), state.title);
    document.title = `${state.title} – takt`;
    const reality = byId("reality");
    setText(reality, state.reality);
    reality.dataset["reality"] = state.reality;
    reality.title = REALITY[state.reality];
    const { overruns, worst_cycle_s } = state.health;
    const worst = worst_cycle_s > 0 ? `worst ${(1000 * worst_cycle_s).toFixed(2)} ms` : "";
    const health = byId("health");
    setText(
      health,
      [state.realtime ? `${overruns} overrun${overruns === 1 ? "" : "s"}` : "lock-step", worst]
        .filter(Boolean)
        .join(", "),
    );
    health.toggleAttribute("data-bad", overruns > 0);
    setText(byId("holder"), holderOf(state, this.link.fence));
  }

  private showAge(): void {
    const age = performance.now() - this.link.heard;
    const isOld = this.link.heard === 0 || age > OLD_MS;
    const text =
      this.link.heard === 0
        ? "not connected"
        : isOld
          ? `no word for ${Math.round(age / 1000)} s`
          : `link ${(Math.floor(age / 100) / 10).toFixed(1)} s`;
    const element = byId("age");
    setText(element, text);
    element.toggleAttribute("data-bad", isOld);
    document.body.toggleAttribute("data-stale", isOld);
  }

  private async stop(): Promise<void> {
    const button = byId("stop");
    button.classList.add("pressed");
    setTimeout(() => button.classList.remove("pressed"), 600);
    try {
      await this.link.ask("POST", "/v1/stop", {});
      this.say("STOP was sent: everything comes to rest.");
    } catch (error) {
      this.say(`STOP did not reach the server: ${wordsOf(error)}. Use the emergency stop of the machine.`);
    }
  }
}

function holderOf(state: State, fence: number): string {
  if (state.program && state.holder === 0) return "a program commands";
  if (state.program)
    return state.holder === fence ? "you drive the program" : `'${state.holder_name}' drives the program`;
  if (state.holder === 0) return "nobody commands";
  return state.holder === fence ? "you command" : `'${state.holder_name}' commands`;
}

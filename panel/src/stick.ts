// A stick for a thumb or a mouse: how far it is pushed, while it is held.
import { h } from "./dom";

const DEAD_SHARE = 0.12;

/** @param push  hears -1 to 1 to the right and up; 0, 0 when it is let go, for whatever reason */
export function stick(label: string, push: (right: number, up: number) => void): HTMLElement {
  const knob = h("div", { class: "knob" });
  const pad = h("div", { class: "stick", "aria-hidden": "true" }, knob, h("span", { class: "sticklabel" }, label));
  const let_go = (): void => {
    knob.style.translate = "";
    push(0, 0);
  };
  const follow = (event: PointerEvent): void => {
    if (!pad.hasPointerCapture(event.pointerId)) return;
    const box = pad.getBoundingClientRect();
    const radius = box.width / 2;
    let right = (event.clientX - box.left - radius) / radius;
    let up = -(event.clientY - box.top - radius) / radius;
    const far = Math.hypot(right, up);
    if (far > 1) {
      right /= far;
      up /= far;
    }
    knob.style.translate = `${right * radius * 0.6}px ${-up * radius * 0.6}px`;
    // Finer near the middle: small movements are what a hand needs most.
    const share = (value: number): number =>
      Math.abs(value) < DEAD_SHARE ? 0 : Math.sign(value) * ((Math.abs(value) - DEAD_SHARE) / (1 - DEAD_SHARE)) ** 1.6;
    push(share(right), share(up));
  };
  pad.addEventListener("pointerdown", (event) => {
    pad.setPointerCapture(event.pointerId);
    follow(event);
  });
  pad.addEventListener("pointermove", follow);
  for (const end of ["lostpointercapture", "pointercancel", "pointerup"]) pad.addEventListener(end, let_go);
  return pad;
}

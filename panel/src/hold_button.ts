// A button that acts while it is held, and no longer.
import { h } from "./dom";

/**
 * Held by the main button of a pointer, or by Space or Enter; a button that loses the focus is let go.
 * @param name  for screen readers; nothing: its text
 */
export function holdButton(text: string, press: () => void, release: () => void, name?: string): HTMLButtonElement {
  const button = h("button", { type: "button", class: "push", "aria-label": name ?? false }, text);
  const begin = (): void => {
    button.classList.add("held");
    press();
  };
  const end = (): void => {
    button.classList.remove("held");
    release();
  };
  const isKey = ({ key }: KeyboardEvent): boolean => key === " " || key === "Enter";
  button.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    button.setPointerCapture(event.pointerId);
    begin();
  });
  for (const over of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) button.addEventListener(over, end);
  button.addEventListener("keydown", (event) => {
    if (!isKey(event) || event.repeat) return;
    event.preventDefault();
    begin();
  });
  button.addEventListener("keyup", (event) => {
    if (isKey(event)) end();
  });
  button.addEventListener("contextmenu", (event) => event.preventDefault());
  return button;
}

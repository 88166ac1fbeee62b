// Light or dark: as the system prefers, or as the button said last.
import { setText } from "./dom";

const KEY = "takt.theme";
type Theme = "light" | "dark";

/** @param changed  hears the colours of pictures */
export function startTheme(
  button: HTMLElement,
  changed: (colors: { background: string; floor: string; line: string }) => void,
): void {
  const prefers = matchMedia("(prefers-color-scheme: light)");
  const current = (): Theme => {
    const chosen = localStorage.getItem(KEY);
    return chosen === "light" || chosen === "dark" ? chosen : prefers.matches ? "light" : "dark";
  };
  const apply = (): void => {
    document.documentElement.dataset["theme"] = current();
    setText(button, current() === "light" ? "Dark" : "Light");
    const style = getComputedStyle(document.documentElement);
    const color = (name: string): string => style.getPropertyValue(name).trim();
    changed({ background: color("--picture"), floor: color("--floor"), line: color("--floor-line") });
  };
  prefers.addEventListener("change", apply);
  button.addEventListener("click", () => {
    localStorage.setItem(KEY, current() === "light" ? "dark" : "light");
    apply();
  });
  apply();
}

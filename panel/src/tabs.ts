import { h } from "./dom";

export interface Tab {
  id: string;
  title: string;
  panel: HTMLElement;
  shown?: (visible: boolean) => void;
}

/** Tabs as the ARIA Authoring Practices describe them: one stop of the tab key, arrows go from tab to tab. */
export class Tabs {
  readonly element: HTMLElement;
  private readonly buttons: HTMLButtonElement[];
  private current = -1;

  constructor(
    label: string,
    private readonly tabs: Tab[],
  ) {
    this.buttons = tabs.map((tab, i) =>
      h(
        "button",
        {
          role: "tab",
          id: `tab-${tab.id}`,
          "aria-controls": `panel-${tab.id}`,
          "aria-selected": "false",
          tabindex: -1,
          type: "button",
          click: () => this.select(i),
        },
        tab.title,
      ),
    );
    for (const tab of tabs) {
      tab.panel.id = `panel-${tab.id}`;
      tab.panel.setAttribute("role", "tabpanel");
      tab.panel.setAttribute("aria-labelledby", `tab-${tab.id}`);
      tab.panel.tabIndex = 0;
      tab.panel.classList.add("tabpanel");
    }
    const list = h(
      "div",
      { role: "tablist", "aria-label": label, keydown: (event: KeyboardEvent) => this.key(event) },
      ...this.buttons,
    );
    this.element = h("div", { class: "tabs" }, list, ...tabs.map((tab) => tab.panel));
    this.select(0);
  }

  show(id: string): void {
    this.select(this.tabs.findIndex((tab) => tab.id === id));
  }

  /** A number beside the title, such as that of faults; 0: none. */
  count(id: string, number: number): void {
    const button = this.buttons[this.tabs.findIndex((tab) => tab.id === id)];
    if (!button) return;
    button.toggleAttribute("data-count", number > 0);
    if (number > 0) button.dataset["count"] = String(number);
  }

  private select(index: number): void {
    if (index < 0 || index === this.current) return;
    const before = this.tabs[this.current];
    this.current = index;
    this.tabs.forEach((tab, i) => {
      const chosen = i === index;
      tab.panel.hidden = !chosen;
      this.buttons[i]?.setAttribute("aria-selected", String(chosen));
      this.buttons[i]?.setAttribute("tabindex", chosen ? "0" : "-1");
    });
    before?.shown?.(false);
    this.tabs[index]?.shown?.(true);
  }

  private key(event: KeyboardEvent): void {
    const last = this.tabs.length - 1;
    const to = {
      ArrowRight: this.current === last ? 0 : this.current + 1,
      ArrowLeft: this.current === 0 ? last : this.current - 1,
      Home: 0,
      End: last,
    }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    this.select(to);
    this.buttons[to]?.focus();
  }
}

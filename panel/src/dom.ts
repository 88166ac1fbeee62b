// Elements of the page, made in one expression. Texts are set as texts: nothing from the server is ever read as HTML.
type Tag = keyof HTMLElementTagNameMap;
type Attributes = Record<string, string | number | boolean | ((event: never) => void)>;

/** An element with children and attributes: a function listens to the event of its name, false leaves one out. */
export function h<K extends Tag>(
  tag: K,
  attributes: Attributes = {},
  ...children: (Node | string)[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value as EventListener);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false) element.setAttribute(name, String(value));
  }
  element.append(...children);
  return element;
}

const SVG = "http://www.w3.org/2000/svg";
export function svg<K extends keyof SVGElementTagNameMap>(
  tag: K,
  attributes: Record<string, string | number> = {},
  ...children: (Node | string)[]
): SVGElementTagNameMap[K] {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no element '${id}'`);
  return found as T;
}

/** Sets a text only when it is another one, so that screen readers hear of changes alone. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** A labelled choice. */
export function choice(
  label: string,
  options: { value: string; text: string }[],
  change: (value: string) => void,
): { label: HTMLLabelElement; select: HTMLSelectElement } {
  const select = h(
    "select",
    { change: () => change(select.value) },
    ...options.map((one) => h("option", { value: one.value }, one.text)),
  );
  return { label: h("label", { class: "field" }, h("span", {}, label), select), select };
}

/** A labelled slider that says its value in words. */
export function slider(
  label: string,
  range: { min: number; max: number; step: number; value: number },
  words: (value: number) => string,
  change: (value: number) => void,
): { label: HTMLLabelElement; input: HTMLInputElement; show: (value: number) => void } {
  const output = h("output", {}, words(range.value));
  const input = h("input", { type: "range", min: range.min, max: range.max, step: range.step, value: range.value });
  const say = (): void => {
    setText(output, words(input.valueAsNumber));
    input.setAttribute("aria-valuetext", words(input.valueAsNumber));
  };
  input.addEventListener("input", () => {
    say();
    change(input.valueAsNumber);
  });
  say();
  return {
    label: h("label", { class: "field slider" }, h("span", {}, label, " ", output), input),
    input,
    show: (value) => {
      if (document.activeElement !== input) {
        input.valueAsNumber = value;
        say();
      }
    },
  };
}

/** Keeps the focus of the keyboard on the page. */

const CONTROLS = "button, select, input, [tabindex]";

/** When the element with the focus is removed, the nearest one takes it, if possible of its kind. */
export function keepFocus(): void {
  let last: Element | null = null;
  document.addEventListener("focusin", ({ target }) => {
    last = target as Element;
  });
  const observer = new MutationObserver((records) => {
    if (last === null || last.isConnected || document.activeElement !== document.body) return;
    const removal = records.find(({ removedNodes }) =>
      [...removedNodes].some((node) => node.contains(last)),
    );
    if (removal === undefined) return;
    const places = [removal.nextSibling, removal.previousSibling, removal.target]
      .filter((node) => node instanceof Element && node.isConnected)
      .map((node) => [...(node as Element).querySelectorAll<HTMLElement>(CONTROLS)]);
    const title = last.getAttribute("title");
    const alike = places.flat().find((control) => title && control.title === title);
    const nearest = places.find((controls) => controls.length > 0)?.[0];
    const first = removal.target.parentElement?.querySelector<HTMLElement>(CONTROLS);
    (alike ?? nearest ?? first)?.focus();
  });
  observer.observe(document.body, { childList: true, subtree: true });
}

// A list of choices that opens inside of the page. A browser's own one is a window of its own: while it is open, the page
// sees no key, and the space bar would choose instead of stopping the motor.

const ROWS = 12;

export function openInPage(element) {
  const open = (event) => {
    event.preventDefault();
    if (!element.disabled) show(element);
  };
  element.addEventListener("mousedown", open);
  element.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && !event.shiftKey) open(event);
    else if (event.key.startsWith("Arrow") || event.key.startsWith("Page") || event.key === "F4") open(event);
    else if (event.key.length === 1 || event.key === "Home" || event.key === "End") event.preventDefault(); // shortcuts, not choices
  });
}

function show(element) {
  const list = document.createElement("select");
  list.className = "choice";
  list.size = Math.max(2, Math.min(ROWS, element.options.length));
  list.append(...[...element.options].map((option) => option.cloneNode(true)));
  list.value = element.value;
  let open = true;
  const close = (chosen) => {
    if (!open) return;
    open = false;
    list.remove();
    if (chosen && list.value && list.value !== element.value) {
      element.value = list.value;
      element.dispatchEvent(new Event("change"));
    }
  };
  // On the list itself it may be its scroll bar.
  list.addEventListener("click", ({ target }) => (target instanceof HTMLOptionElement || list.value !== element.value) && close(true));
  list.addEventListener("keydown", (event) => {
    if (event.key === "Enter") close(true);
    else if (event.key === "Tab") close(false);
  });
  list.addEventListener("blur", () => close(false));
  document.body.append(list);
  place(list, element.getBoundingClientRect());
  list.focus();
}

// Below what it belongs to, above if there is more room, and inside of the window.
function place(list, at) {
  const { width, height } = list.getBoundingClientRect();
  const below = innerHeight - at.bottom >= height || innerHeight - at.bottom >= at.top;
  list.style.left = `${Math.max(4, Math.min(at.left, innerWidth - width - 4))}px`;
  list.style.top = `${Math.max(4, below ? Math.min(at.bottom, innerHeight - height - 4) : at.top - height)}px`;
  list.style.minWidth = `${at.width}px`;
}

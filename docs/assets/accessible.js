// Tables and equations that scroll are reached by the keyboard, and the buttons at code are no landmarks.
// The theme wraps tables and adds these buttons in the browser, at any time.
"use strict";
(() => {
  const NAMES = { "md-typeset__scrollwrap": "Table", equation: "Equation" };

  const nameParts = () => {
    for (const [kind, name] of Object.entries(NAMES)) {
      for (const part of document.querySelectorAll(`.${kind}:not([tabindex])`)) {
        part.tabIndex = 0;
        part.setAttribute("role", "group");
        part.setAttribute("aria-label", name);
      }
    }
    for (const part of document.querySelectorAll(".md-code__nav:not([role])")) {
      part.setAttribute("role", "none");
    }
  };

  nameParts();
  new MutationObserver(nameParts).observe(document.body, { childList: true, subtree: true });
})();

/** Files dropped on the page, from its first moment on: the browser would else leave it for them. */

/** @type {File[]} */
let held = [];
/** @type {((files: File[]) => void) | undefined} */
let taker;

export function listenToDrops() {
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    held.push(...(event.dataTransfer?.files ?? []));
    handOver();
  });
}

/** Who takes them, those that have come before too. @param {(files: File[]) => void} take */
export function onDrop(take) {
  taker = take;
  handOver();
}

function handOver() {
  if (!taker) return;
  taker(held);
  held = [];
}

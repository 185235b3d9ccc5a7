'use strict';
// The matrix of classes: what the pointer or the focus is on is shown beside it; arrows lead from cell to cell.
{
  const matrix = document.querySelector('.matrix'), peek = document.querySelector('.peek');
  const cells = [...matrix.querySelectorAll('td a')];

  const show = cell => {
    const picture = peek.querySelector('img') || peek.appendChild(new Image());
    const words = peek.querySelector('span') || peek.appendChild(document.createElement('span'));
    picture.alt = '';
    picture.src = cell.getAttribute('href').replace(/\.html$/, '.svg');
    words.textContent = cell.getAttribute('aria-label');
  };
  for (const name of ['pointerover', 'focusin']) {
    matrix.addEventListener(name, event => { if (event.target.matches('td a')) show(event.target); });
  }

  // One stop of the tab key for the whole matrix.
  const stop = cell => {
    for (const one of cells) one.tabIndex = one === cell ? 0 : -1;
  };
  matrix.addEventListener('focusin', event => { if (event.target.matches('td a')) stop(event.target); });
  matrix.addEventListener('keydown', event => {
    const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
    if (!step || !event.target.matches('td a')) return;
    const at = event.target.getBoundingClientRect();
    const way = cell => {
      const box = cell.getBoundingClientRect(), x = box.left - at.left, y = box.top - at.top;
      const straight = x * step[0] + y * step[1];
      return straight > 1 && Math.abs(x * step[1] + y * step[0]) < 1 ? straight : Infinity;
    };
    const next = cells.reduce((best, cell) => way(cell) < way(best) ? cell : best);
    if (way(next) < Infinity) next.focus();
    event.preventDefault();
  });
  if (cells.length) {
    stop(cells[0]);
    show(cells[0]);
    peek.hidden = false;
  }
}

'use strict';
(() => {
  const form = document.querySelector('.quiz'), pairs = [...form.querySelectorAll('fieldset')];
  const said = form.querySelector('output'), answers = document.getElementById('answers');
  const reveal = document.querySelector('.reveal'), submit = form.querySelector('[type=submit]');
  const chosen = pair => pair.querySelector('input:checked')?.value;

  function count() {
    said.textContent = `${pairs.filter(chosen).length} of ${pairs.length} answered`;
  }

  function judge() {
    let right = 0;
    for (const pair of pairs) {
      const verdict = pair.querySelector('.verdict'), good = chosen(pair) === pair.dataset.right;
      right += good;
      verdict.textContent = good ? '✓ right' : chosen(pair) ? '✗ wrong' : '✗ not answered';
      verdict.classList.toggle('wrong', !good);
      verdict.hidden = false;
      pair.disabled = true;
    }
    const share = Math.round(100 * right / pairs.length);
    said.textContent = `You: ${right} of ${pairs.length} right (${share} %). ${said.dataset.beside}`;
    submit.hidden = reveal.hidden = true;
    answers.classList.add('shown');
    form.querySelector('[type=reset]').focus();  // the other button, which had it, is gone
  }

  function begin() {
    for (const pair of pairs) {
      pair.disabled = false;
      pair.querySelector('.verdict').hidden = true;
    }
    submit.hidden = reveal.hidden = false;
    answers.classList.remove('shown');
    if (location.hash) history.replaceState(null, '', location.pathname);
    count();
  }

  form.addEventListener('input', count);
  form.addEventListener('submit', event => { event.preventDefault(); judge(); });
  form.addEventListener('reset', () => setTimeout(begin));
  addEventListener('keydown', event => {
    const value = {y: 'yes', n: 'no'}[event.key.toLowerCase()];
    if (!value || event.ctrlKey || event.metaKey || event.altKey || submit.hidden) return;
    const open = pairs.filter(pair => !chosen(pair));
    const pair = document.activeElement.closest('fieldset') || open[0];
    if (!pair) return;
    pair.querySelector(`[value=${value}]`).checked = true;
    count();
    const next = pairs.slice(pairs.indexOf(pair) + 1).find(one => !chosen(one)) || pairs.find(one => !chosen(one));
    (next ? next.querySelector('input') : submit).focus();
    event.preventDefault();
  });
  form.querySelector('.score').hidden = false;
  count();
})();

'use strict';
const typing = event => event.target.matches('input:not([type=checkbox]),select,textarea') ||
  event.ctrlKey || event.metaKey || event.altKey;

function gallery(form, list) {
  const field = form.elements, shown = document.querySelector('.shown');
  const orders = [...field.sort.options];
  const items = [...list.children].map((node, place) => ({
    node, place,
    values: node.dataset.v.split(' ').map(Number),
    classes: node.dataset.c.split(' '),
    marks: node.dataset.m,
    text: (node.querySelector('b').textContent + ' ' + node.querySelector('small').firstChild.data + ' ' +
      node.dataset.c.split(' ').map(k => k && field.class.options[+k + 1].text).join(' ')).toLowerCase(),
  }));
  const at = Object.fromEntries(orders.map(order => [order.value, +order.dataset.at]));
  const ticks = [...form.querySelectorAll('[data-mark]')];
  let visible = items, sorted = '';

  function sort() {
    const key = field.sort.value;
    const sign = (field.reverse.checked ? -1 : 1) * field.sort.selectedOptions[0].dataset.sign;
    if (key + sign === sorted) return;
    sorted = key + sign;
    const value = item => item.values[at[key]];
    items.sort((a, b) => isNaN(value(a)) - isNaN(value(b)) || sign * (value(a) - value(b)) || a.place - b.place);
    list.append(...items.map(item => item.node));
  }

  function filter() {
    const words = field.q.value.toLowerCase().split(/\s+/).filter(Boolean);
    const kind = field.class.value, n = field.n.value, least = +field.iou.value, open = least <= +field.iou.min;
    const passes = item =>
      words.every(word => item.text.includes(word)) &&
      (!kind || item.classes.includes(kind)) && (!n || item.values[at.n] === +n) &&
      (open || item.values[at.iou] >= least) &&
      ticks.every(({checked, dataset: {mark}}) =>
        !checked || (mark[0] === '!' ? !item.marks.includes(mark[1]) : item.marks.includes(mark)));
    visible = items.filter(item => !(item.node.hidden = !passes(item)));
    form.querySelector('output').value = least.toFixed(2);
    shown.textContent = visible.length === items.length ? `${items.length} transforms`
      : `${visible.length} of ${items.length} transforms`;
  }

  function remember() {
    const chosen = new URLSearchParams();
    for (const one of field) {
      if (one.type === 'checkbox' ? one.checked : one.name && one.value !== start[one.name]) {
        chosen.set(one.name, one.type === 'checkbox' ? 1 : one.value);
      }
    }
    history.replaceState(null, '', '#' + chosen);
  }

  function recall() {
    for (const [name, value] of new URLSearchParams(location.hash.slice(1))) {
      const one = field[name];
      if (!one) continue;
      if (one.type === 'checkbox') one.checked = true;
      else if (one.tagName !== 'SELECT' || [...one.options].some(option => option.value === value)) one.value = value;
    }
  }

  const update = () => { sort(); filter(); };
  const start = {};
  form.reset();
  for (const one of field) if (one.name) start[one.name] = one.value;
  recall();
  update();
  form.hidden = false;
  form.addEventListener('input', () => { update(); remember(); });
  form.addEventListener('submit', event => event.preventDefault());
  form.addEventListener('reset', () => setTimeout(() => { update(); remember(); }));
  addEventListener('hashchange', () => { form.reset(); setTimeout(() => { recall(); update(); }); });

  const link = item => item.node.firstElementChild;
  addEventListener('keydown', event => {
    if (event.key === 'Escape' && event.target === field.q) {
      if (field.q.value) { field.q.value = ''; update(); remember(); } else field.q.blur();
      return event.preventDefault();
    }
    if (event.key === 'Enter' && event.target === field.q && visible.length) return link(visible[0]).focus();
    if (typing(event)) return;
    if (event.key === '/') { field.q.focus(); field.q.select(); return event.preventDefault(); }
    const now = visible.findIndex(item => link(item) === document.activeElement);
    const top = visible.length && visible[0].node.offsetTop;
    const row = Math.max(1, visible.findIndex(item => item.node.offsetTop > top));
    const step = {ArrowLeft: -1, ArrowRight: 1, ArrowUp: -row, ArrowDown: row}[event.key];
    let next = step === undefined ? -1 : now < 0 ? -1 : now + step;
    if (now < 0 && step > 0 && document.activeElement === document.body) next = 0;
    if (now >= 0 && event.key === 'Home') next = 0;
    if (now >= 0 && event.key === 'End') next = visible.length - 1;
    if (!visible[next]) return;
    link(visible[next]).focus();
    event.preventDefault();
  });
}

function single() {
  const keys = {ArrowLeft: 'prev', ArrowRight: 'next', Escape: 'up'};
  addEventListener('keydown', event => {
    const link = !typing(event) && keys[event.key] && document.querySelector(`a[rel=${keys[event.key]}]`);
    // Not from a box that scrolls: there the arrows scroll.
    if (link && !(event.target.closest('.scroll') && event.key !== 'Escape')) link.click();
  });
}

const form = document.querySelector('.controls'), list = document.querySelector('.wall');
if (form && list) gallery(form, list);
else if (!form) single();

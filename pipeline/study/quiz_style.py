"""How the quiz looks on screen and on paper, and its script. Ours."""

from __future__ import annotations

from pipeline.report.style import style_sheet
from riot.draw.palette import LIGHT
from riot.draw.svg import page_colours

_RULES = """
.questions{list-style:none;margin:30px 0 0;padding:0;display:grid;gap:14px;
grid-template-columns:repeat(auto-fill,minmax(min(100%,260px),1fr))}
fieldset{margin:0;border:0;min-width:0;background:var(--r-paper);border-radius:14px;padding:14px 16px 12px}
legend{float:left;width:100%;padding:0;font-size:.85rem;color:var(--r-muted)}
.two{clear:both;display:grid;grid-template-columns:1fr 1fr;gap:10px}
.two svg{display:block;width:100%;height:auto}
.two .r-silhouette{fill:var(--r-ink)}
.choices{display:flex;gap:8px;margin-top:8px}
.choices label{flex:1;display:flex;align-items:center;gap:8px;min-height:44px;padding:0 10px;
border:1px solid var(--line);border-radius:9px;cursor:pointer}
.choices label:hover{border-color:var(--link)}
.choices label:has(:checked){border-color:var(--link);box-shadow:inset 0 0 0 1px var(--link)}
.choices label:has(:focus-visible){outline:3px solid var(--link);outline-offset:1px}
.choices input{width:18px;height:18px;margin:0;accent-color:var(--link)}
fieldset:disabled label{cursor:default}
.verdict{margin:.5rem 0 0;font-weight:600}
.verdict.wrong{color:var(--warm)}
.score{position:sticky;bottom:0;display:flex;flex-wrap:wrap;align-items:center;gap:8px 14px;margin:20px -12px 0;
padding:12px;background:var(--page);border-top:1px solid var(--line)}
.score[hidden],.verdict[hidden]{display:none}
.score output{flex:1 1 20rem}
.score button{font:inherit;min-height:44px;padding:4px 18px;color:var(--r-ink);background:var(--r-paper);
border:1px solid var(--line);border-radius:9px;cursor:pointer}
.score button:focus-visible{outline:3px solid var(--link);outline-offset:1px}
.keys{flex-basis:100%;margin:0;font-size:.85rem;color:var(--r-muted)}
kbd{font:inherit;border:1px solid var(--line);border-radius:4px;padding:0 5px}
.reveal{margin:26px 0 0}
.made{display:grid;gap:12px;margin-top:16px;grid-template-columns:repeat(auto-fill,minmax(200px,1fr))}
.made figure{margin:0;background:var(--r-paper);border-radius:12px;padding:10px}
.made img{display:block;width:100%;height:auto}
@media (pointer:coarse){.keys{display:none}}
@media (max-width:560px){.score{margin:16px -14px 0;padding:10px 14px}
.score output{flex-basis:100%}.score button{flex:1}}
@media screen{#answers:not(:target):not(.shown){display:none}}
@page{size:A4;margin:11mm}
@media print{
html{color-scheme:light;font-size:11px}
body{font-size:11px}
main,.top{max-width:none;padding:0}
h1{font-size:1.8rem}
.lead{margin:.3rem 0 0;max-width:none;font-size:1.05rem}
.questions{margin-top:12px;gap:7px;grid-template-columns:repeat(4,1fr)}
fieldset{border:1px solid var(--line);padding:7px 9px;break-inside:avoid}
.two{gap:5px}
.choices{gap:0;margin-top:4px}
.choices label{border:0!important;box-shadow:none!important;min-height:0;padding:0;gap:5px}
.choices input{width:13px;height:13px}
.score,.reveal{display:none!important}
#answers{break-before:page;margin:0}
#answers .note{max-width:none;margin-bottom:8px}
#answers .sheet{padding:4px 10px}
#answers th,#answers td{padding:.26rem .9rem .26rem 0}
.made{grid-template-columns:repeat(4,1fr);gap:7px;margin-top:10px}
.made figure{border:1px solid var(--line);padding:6px;break-inside:avoid}
}
"""

SCRIPT_TEXT = r"""'use strict';
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
"""


def quiz_style() -> str:
    """All rules of the page: those of the report, and the quiz's own. On paper it is light whatever the screen is."""
    return f"{style_sheet()}{_RULES.lstrip()}@media print{{:root{{--line:#bbb;{page_colours(LIGHT)}}}}}\n"

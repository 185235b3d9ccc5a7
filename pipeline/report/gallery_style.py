"""The style sheet of the gallery: that of the report, and rules of its own. Ours."""

from __future__ import annotations

from pipeline.report.style import style_sheet

_RULES = """
.kicker a{color:inherit}
.grid{list-style:none;margin:14px 0 0;padding:0;display:grid;gap:12px;
grid-template-columns:repeat(auto-fill,minmax(min(100%,218px),1fr))}
.grid li{content-visibility:auto;contain-intrinsic-size:auto 190px}
.grid li[hidden]{display:none}
.grid a{display:block;height:100%;background:var(--r-paper);border-radius:12px;padding:10px 12px 12px;
color:var(--r-ink);text-decoration:none}
.grid a:hover{box-shadow:0 0 0 2px var(--link)}
.grid a:focus-visible{outline:3px solid var(--link);outline-offset:-3px}
.grid img{display:block;width:100%;height:auto;aspect-ratio:2}
.grid b{display:block;margin-top:.4rem;font-weight:600;font-size:.92rem;line-height:1.3;overflow-wrap:anywhere}
.grid small{color:var(--r-muted);font-size:.82rem}
.controls{position:sticky;top:0;z-index:1;display:flex;flex-wrap:wrap;gap:10px 16px;align-items:end;margin:26px -12px 0;
padding:12px;background:var(--page);border-bottom:1px solid var(--line);font-size:.82rem;color:var(--r-muted)}
.controls[hidden]{display:none}
.controls label{display:flex;flex-direction:column;gap:3px}
.controls .tick{flex-direction:row;align-items:center;gap:6px;min-height:36px}
.controls .wide{flex:1 1 170px}
.controls input,.controls select,.controls button{font:inherit;font-size:.95rem;color:var(--r-ink);max-width:100%}
.controls select,.controls [type=search],.controls button{min-height:36px;padding:4px 8px;background:var(--r-paper);
border:1px solid var(--line);border-radius:8px}
.controls select{max-width:170px}
.controls [type=range]{width:120px;height:36px;margin:0;accent-color:var(--link)}
.controls [type=checkbox]{width:18px;height:18px;margin:0;accent-color:var(--link)}
.controls :focus-visible{outline:2px solid var(--link);outline-offset:1px}
.controls output{color:var(--r-ink)}
kbd{font:inherit;border:1px solid var(--line);border-radius:4px;padding:0 5px}
.shown{margin:12px 0 0;color:var(--r-muted);font-size:.9rem}
.top nav{margin:0 0 1.4rem}
.top .class{font:400 1rem/1 ui-sans-serif,system-ui,'Segoe UI',Arial,sans-serif;color:var(--r-muted)}
.top .arrow{color:var(--r-muted);font-weight:400}
.top .worth{margin:.6rem 0 0}
.sheet .facts{border-top:0;margin-top:0;padding-top:6px}
main>.card{margin-top:30px}
pre{margin:0;padding:8px 0;font-size:.82rem;line-height:1.5}
@media (max-width:560px){
.controls{position:static}
.controls select{max-width:46vw}
.grid{grid-template-columns:repeat(2,minmax(0,1fr));gap:8px}
.grid a{padding:8px}
.facts{grid-template-columns:repeat(2,minmax(0,1fr))}
}
"""


def gallery_style() -> str:
    """All rules of the gallery's pages."""
    return style_sheet() + _RULES.lstrip()

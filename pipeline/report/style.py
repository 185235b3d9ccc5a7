"""The style sheet of the report. Ours."""

from __future__ import annotations

from riot.draw.animate import MOTION_STYLE
from riot.draw.palette import DARK, LIGHT
from riot.draw.svg import page_colours, page_style

_LIGHT = "--page:#f6f4ef;--line:#e4e0d7;--bar:#8d93a0;--link:#2f6aa8;--warm:#a94755;"
_DARK = "--page:#131519;--line:#30343b;--bar:#7d8490;--link:#84b4e6;--warm:#e08a97;"

_RULES = """
*{box-sizing:border-box}
html{color-scheme:light dark;-webkit-text-size-adjust:100%}
body{margin:0;background:var(--page);color:var(--r-ink);font:16px/1.55 ui-sans-serif,system-ui,'Segoe UI',
'Helvetica Neue',Arial,sans-serif;font-variant-numeric:tabular-nums}
main,.top,footer{max-width:1180px;margin:0 auto;padding:0 28px}
.top{padding-top:56px}
h1,h2,h3{font-family:'Iowan Old Style','Palatino Linotype',Palatino,'Book Antiqua',Georgia,serif;font-weight:600;
line-height:1.2;overflow-wrap:anywhere}
h1{font-size:clamp(2.1rem,5vw,3.2rem);margin:0;letter-spacing:-.01em}
h2{font-size:1.65rem;margin:0 0 .4rem}
h3{font-size:1.2rem;margin:0}
.kicker{margin:0 0 .5rem;color:var(--r-muted);font-size:.82rem;letter-spacing:.09em;text-transform:uppercase}
.remark{max-width:46rem;margin:.9rem 0 0}
.lead{max-width:46rem;margin:.9rem 0 0;font-size:1.08rem;color:var(--r-muted)}
.note{max-width:46rem;margin:0 0 1.2rem;color:var(--r-muted)}
section{margin:64px 0 0}
a{color:var(--link);text-underline-offset:.15em;text-decoration-thickness:.06em}
a:focus-visible,.scroll:focus-visible,summary:focus-visible{outline:2px solid var(--link);outline-offset:2px}
nav{display:flex;flex-wrap:wrap;gap:.3rem 1.3rem;margin-top:1.6rem;font-size:.95rem}
.tiles{display:grid;grid-template-columns:repeat(4,minmax(0,1fr));gap:12px;margin:36px 0 0;padding:0}
.tiles div{background:var(--r-paper);border-radius:12px;padding:16px 18px}
.tiles dt{color:var(--r-muted);font-size:.85rem}
.tiles dd{margin:0;font-size:1.55rem;line-height:1.25;font-family:'Iowan Old Style','Palatino Linotype',Palatino,
'Book Antiqua',Georgia,serif}
.sheet{background:var(--r-paper);border-radius:14px;padding:10px 18px}
.scroll{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.93rem}
th{font-weight:500;color:var(--r-muted);font-size:.82rem;text-align:left;white-space:nowrap}
th,td{padding:.5rem .9rem .5rem 0;border-bottom:1px solid var(--line);vertical-align:top}
th:last-child,td:last-child{padding-right:0}
tbody tr:last-child td{border-bottom:0}
td.n,th.n{text-align:right;white-space:nowrap}
td{overflow-wrap:break-word}
.pair{min-width:10rem}
.long{min-width:15rem;overflow-wrap:anywhere}
.share{display:block;min-width:110px;height:9px;margin-top:.45em;border-radius:5px;background:var(--line);overflow:hidden}
.share i{display:block;height:100%;background:var(--r-piece0);border-radius:5px}
.unseen{position:absolute;width:1px;height:1px;overflow:hidden;clip-path:inset(50%);white-space:nowrap}
.plots{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,400px),1fr));gap:16px;align-items:start}
.plots .wide{grid-column:1/-1}
.plot{margin:0;background:var(--r-paper);border-radius:14px;padding:18px}
.plot svg{display:block;width:100%;height:auto}
.plot figcaption{text-align:left;margin-top:.6rem;font-size:.9rem;color:var(--r-muted)}
.plot b{color:var(--r-ink);font-weight:600;margin-right:.4em}
.plot text{font-size:10.5px;fill:var(--r-muted)}
.plot .grid{stroke:var(--line);stroke-width:1;fill:none}
.plot .bar{fill:var(--r-piece0)}
.plot .bar:hover{fill:var(--r-piece4)}
.thumbs{display:grid;grid-template-columns:repeat(auto-fill,minmax(132px,1fr));gap:10px;margin:0 0 26px}
.thumb{--r-seam:transparent;display:flex;background:var(--r-paper);border-radius:10px;padding:6px}
.thumb:hover{box-shadow:0 0 0 2px var(--link)}
.thumb svg{width:50%;height:auto;aspect-ratio:1}
.card{background:var(--r-paper);border-radius:16px;padding:24px 26px 20px;margin:0 0 22px;
content-visibility:auto;contain-intrinsic-size:auto 640px;scroll-margin-top:16px}
.card header{display:flex;align-items:baseline;gap:14px;margin-bottom:12px}
.card .rank{color:var(--r-muted);font-size:.95rem;min-width:1.3em}
.card h3{flex:1;min-width:0}
.card .class{font:400 .8rem/1 ui-sans-serif,system-ui,'Segoe UI',Arial,sans-serif;color:var(--r-muted)}
.card .arrow{color:var(--r-muted);font-weight:400;margin:0 .25em}
.worth{margin:0;color:var(--r-muted);white-space:nowrap}
.worth b{color:var(--r-ink);font-size:1.2rem;font-weight:600}
.pictures{display:grid;grid-template-columns:minmax(0,3fr) minmax(0,2.2fr);gap:18px 30px;align-items:center}
.panels{display:grid;grid-template-columns:repeat(3,minmax(0,1fr));gap:12px 16px}
.moves{display:grid;gap:14px}
.card figure{margin:0;min-width:0}
.card svg{display:block;width:100%;height:auto}
.panels svg{max-height:260px}
.swing{max-height:280px}
.chain{max-height:190px}
figcaption{text-align:center;font-size:.8rem;line-height:1.35;color:var(--r-muted);margin-top:.35rem}
.facts{display:grid;grid-template-columns:repeat(6,auto);gap:.7rem 1.4rem;margin:18px 0 0;padding-top:14px;
border-top:1px solid var(--line)}
.facts dt{font-size:.78rem;color:var(--r-muted)}
.facts dd{margin:0;white-space:nowrap;font-size:.95rem}
.facts i{font-style:normal;color:var(--r-muted)}
sup{font-size:.7em;line-height:0}
details{margin-top:12px}
summary{cursor:pointer;padding:.3rem 0;color:var(--link)}
.tree td:first-child{color:var(--r-muted);width:34%;min-width:9rem;overflow-wrap:anywhere}
.tree td{overflow-wrap:anywhere}
.empty{color:var(--r-muted);font-style:italic}
footer{padding-top:56px;padding-bottom:64px;color:var(--r-muted);font-size:.88rem}
@media (max-width:1080px){.facts{grid-template-columns:repeat(auto-fill,minmax(145px,1fr))}}
@media (max-width:860px){.pictures{grid-template-columns:minmax(0,1fr)}}
@media (max-width:560px){
main,.top,footer{padding-left:14px;padding-right:14px}
.top{padding-top:32px}
section{margin-top:46px}
.card{padding:18px 14px 14px;border-radius:13px}
.card header{flex-wrap:wrap;gap:4px 10px}
.card h3{flex-basis:75%}
.worth{margin-left:2.2em}
.panels{gap:10px 8px}
.panels figcaption{font-size:.7rem}
.thumbs{grid-template-columns:repeat(auto-fill,minmax(104px,1fr))}
.tiles{grid-template-columns:repeat(2,minmax(0,1fr))}
.tiles dd{font-size:1.3rem}
.sheet{padding:6px 14px}
}
@media print{body{background:none}.card,.sheet,.plot,.tiles div{break-inside:avoid;border:1px solid var(--line)}
.card{content-visibility:visible}}
"""


def style_sheet() -> str:
    """All rules of the page, the pictures' too; light or dark as the reader's system has it."""
    return (
        f":root{{{_LIGHT}{page_colours(LIGHT)}}}\n"
        f"@media (prefers-color-scheme:dark){{:root{{{_DARK}{page_colours(DARK)}}}}}\n"
        f"{_RULES}{page_style()}\n{MOTION_STYLE}\n"
    )

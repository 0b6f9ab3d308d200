// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/style.h"

namespace panelcal::report {

const std::string_view kStyle = R"css(
:root{color-scheme:light dark;--page:#f4f5f7;--paper:#fff;--ink:#1b2530;--quiet:#5b6774;--line:#d8dde3;
--soft:#eef1f4;--link:#0a5ea8;--good:#157347;--good-soft:#dff3e7;--bad:#b3261e;--bad-soft:#fbe3e1;
--warn:#8a5a00;--warn-soft:#fdf0d2;--shift:#6a43b5}
@media screen and (prefers-color-scheme:dark){:root{--page:#12171d;--paper:#1b222a;--ink:#e6ebf0;
--quiet:#9aa7b4;--line:#35404b;--soft:#252e38;--link:#79b8ff;--good:#4cc38a;--good-soft:#14372a;
--bad:#ff8078;--bad-soft:#4a201e;--warn:#f0b94a;--warn-soft:#43340f;--shift:#b79bff}}
*{box-sizing:border-box}
body{margin:0;background:var(--page);color:var(--ink);font:15px/1.45 system-ui,-apple-system,"Segoe UI",
"DejaVu Sans",sans-serif;font-variant-numeric:tabular-nums;overflow-wrap:break-word}
main{max-width:1120px;margin:0 auto;padding:16px}
h1{font-size:15px;font-weight:500;margin:0 0 10px;color:var(--quiet)}
h1 b{color:var(--ink)}
h2{font-size:19px;margin:26px 0 10px}
h3{font-size:15px;margin:14px 0 8px}
p{margin:6px 0}a{color:var(--link)}
.quiet{color:var(--quiet)}
section,.verdict{background:var(--paper);border:1px solid var(--line);border-radius:10px;padding:14px 16px}
.verdict{border-left:10px solid var(--good)}
.verdict.hold{border-left-color:var(--bad)}.verdict.forced{border-left-color:var(--warn)}
.verdict .top{display:flex;gap:16px;align-items:center;flex-wrap:wrap}
.word{font-size:34px;font-weight:800;letter-spacing:.04em;line-height:1;padding:10px 16px;border-radius:8px;
color:var(--good);background:var(--good-soft)}
.hold .word{color:var(--bad);background:var(--bad-soft)}
.forced .word{color:var(--warn);background:var(--warn-soft)}
.top p{flex:1 1 260px;font-size:16px;margin:0}
.next{margin:12px 0 0;padding:10px 14px;border-radius:8px;background:var(--soft);font-size:16px}
.tiles{display:grid;grid-template-columns:repeat(auto-fit,minmax(230px,1fr));gap:10px;margin:12px 0 0;padding:0}
.tiles div{border:1px solid var(--line);border-radius:8px;padding:8px 12px}
.tiles dt{color:var(--quiet);font-size:13px}
.tiles dd{margin:2px 0 0;font-size:20px;font-weight:650}
.tiles small{display:block;font-size:12.5px;font-weight:400;color:var(--quiet)}
.meter{display:block;height:7px;min-width:70px;border-radius:4px;background:var(--soft);margin:5px 0;overflow:hidden}
.meter span{display:block;height:100%;background:var(--good)}
.meter.refused span{background:var(--bad)}
.chip{display:inline-block;padding:0 7px;border-radius:9px;font-size:12.5px;font-weight:600;white-space:nowrap;
color:var(--good);background:var(--good-soft)}
.chip.refused,.chip.error{color:var(--bad);background:var(--bad-soft)}
.chip.suspect,.chip.warning{color:var(--warn);background:var(--warn-soft)}
.figures{display:grid;grid-template-columns:minmax(0,3fr) minmax(0,2fr);gap:8px 24px;align-items:start}
.figures.single{grid-template-columns:minmax(0,1fr)}
figure{margin:0}figure.main{grid-row:span 2}
figcaption{font-size:13px;color:var(--quiet);margin-top:4px}
figcaption b{color:var(--ink)}
svg.panel{display:block;width:100%;height:auto;margin:0 auto;overflow:visible}
svg text{font:12px system-ui,"DejaVu Sans",sans-serif;fill:var(--quiet)}
svg .mid{text-anchor:middle}svg .end{text-anchor:end}
svg path,svg rect,svg circle{fill:none;stroke-linecap:round;stroke-linejoin:round}
.grid{stroke:var(--line);stroke-width:.6}.frame{stroke:var(--quiet);stroke-width:.8}
.bar{stroke:var(--ink);stroke-width:1.3}
.arrow{stroke-width:1.7;stroke:var(--link)}
.arrow.refused{stroke:var(--bad);stroke-width:2.4}.arrow.suspect{stroke:var(--warn)}
.arrow.shift{stroke:var(--shift);stroke-width:1.2}
.before{stroke:var(--quiet);stroke-dasharray:4 4;stroke-width:1}.after{stroke:var(--shift);stroke-width:1.6}
.mark>*{stroke:var(--ink);stroke-width:1.4;pointer-events:all}
.mark.suspect>*{stroke:var(--warn)}.mark.refused>*{stroke:var(--bad);stroke-width:2.4}
.many .mark>*{stroke-width:.8}
.mark text,.mark.suspect text,.mark.refused text{stroke:var(--paper);stroke-width:3px;paint-order:stroke;
fill:var(--ink);font-size:11px}
.mark.refused text{fill:var(--bad);font-weight:700}
.legend{list-style:none;display:flex;flex-wrap:wrap;gap:2px 16px;margin:8px 0 4px;padding:0;font-size:13px}
.dot{display:inline-block;width:10px;height:10px;border-radius:5px;margin-right:5px}
.cards{display:grid;grid-template-columns:repeat(auto-fill,minmax(310px,1fr));gap:10px;margin:8px 0}
.card{border:1px solid var(--line);border-radius:8px;padding:10px;break-inside:avoid;font-size:13px}
.head{display:flex;gap:12px;align-items:flex-start}.head>div:last-child{min-width:0;flex:1}
.card.refused{border:2px solid var(--bad)}.card.suspect{border-color:var(--warn)}
.card:target{outline:3px solid var(--link)}
.card h4{margin:0;font-size:14px}.card p{margin:1px 0}
.card img,.nopicture{width:88px;height:88px;object-fit:cover;object-position:top;border-radius:6px;background:var(--soft);flex:none}
.card img{cursor:zoom-in}
.card img:focus,.card.refused img:focus{position:fixed;inset:2vh 2vw;width:96vw;height:96vh;z-index:9;cursor:zoom-out;
object-fit:contain;object-position:center;outline:2px solid var(--line);background:var(--paper)}
.nopicture{display:flex;align-items:center;justify-content:center;color:var(--quiet)}
.card.refused img,.card.refused .nopicture{width:140px;height:140px}
.card table{border-collapse:collapse;margin-top:6px;width:100%}
.card th,.card td{text-align:right;font-weight:400;padding:0 0 0 8px;white-space:nowrap}
.card th{color:var(--quiet)}.card th:first-child{text-align:left;padding:0}.card th b{color:var(--ink)}
.reason{color:var(--bad);font-weight:600}
table.grid{border-collapse:collapse}
table.grid th{text-align:left;color:var(--quiet);font-weight:500;font-size:13px}
table.grid th,table.grid td{padding:3px 14px 3px 0;border-bottom:1px solid var(--line)}
table.grid th.num,table.grid td.num{text-align:right;white-space:nowrap}
.scroll table.grid td:last-child:not(.num){min-width:26em}
.scroll table.grid td:first-child{min-width:8em}.scroll+.scroll{margin-top:14px}
table.grid tr:last-child td{border-bottom:0}
.scroll{overflow-x:auto}
details{border-top:1px solid var(--line);padding:6px 0}
details:first-of-type{border-top:0}
details details{margin-left:16px}
summary{cursor:pointer}
.fit>p,.fit>.scroll{margin-left:18px}
.messages{list-style:none;margin:0;padding:0}
.messages li{padding:6px 0;border-top:1px solid var(--line)}
.messages li:first-child{border-top:0}
code,.mono{font-family:ui-monospace,"DejaVu Sans Mono",monospace;font-size:12.5px;overflow-wrap:anywhere}
footer{margin:22px 0 10px;font-size:13px;color:var(--quiet)}
footer dl{display:grid;grid-template-columns:minmax(110px,max-content) minmax(0,1fr);gap:2px 14px}
footer dt{overflow-wrap:anywhere;max-width:260px}footer dd{margin:0;overflow-wrap:anywhere}
@media (max-width:720px){.figures{grid-template-columns:minmax(0,1fr)}main{padding:8px}
section,.verdict{padding:10px}.cards{grid-template-columns:minmax(0,1fr)}
.tiles{grid-template-columns:repeat(auto-fit,minmax(140px,1fr))}.tiles dd{font-size:17px}
svg text{font-size:14px}footer dl{grid-template-columns:minmax(0,1fr)}footer dt{margin-top:4px}}
@media print{@page{margin:12mm}body{background:#fff;font-size:11px}main{max-width:none;padding:0}
*{-webkit-print-color-adjust:exact;print-color-adjust:exact}
section{border:0;padding:0}h2{break-after:avoid}figure,.verdict,.fit,tr,li{break-inside:avoid}
.word{font-size:26px}.card img,.nopicture{width:80px;height:80px}
.cards{grid-template-columns:repeat(3,minmax(0,1fr))}.card{font-size:9.5px}a{color:inherit}}
)css";

}  // namespace panelcal::report

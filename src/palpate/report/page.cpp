#include <palpate/report/page.h>

#include <fmt/format.h>

#include <palpate/report/markup.h>

namespace palpate {
namespace {

constexpr const char* kPageStyle = R"(
:root{color-scheme:light dark;--page:#f4f5f7;--card:#fff;--ink:#1b2430;--muted:#576373;--border:#dde1e7}
@media(prefers-color-scheme:dark){:root{--page:#0e1217;--card:#161b22;--ink:#e4e9f0;--muted:#98a5b5;--border:#2a323d}}
*{box-sizing:border-box}
body{margin:0 auto;padding:20px clamp(10px,2vw,28px);max-width:1280px;background:var(--page);color:var(--ink);
font:14px/1.45 system-ui,-apple-system,'Segoe UI',Roboto,sans-serif}
h1{font-size:22px;line-height:1.25;margin:0 0 4px}h2{font-size:16px;margin:26px 0 4px}
p{margin:0 0 10px;color:var(--muted);max-width:80ch}
figure,.table{margin:0;background:var(--card);border:1px solid var(--border);border-radius:10px;overflow:hidden}
.figures{display:grid;gap:12px;grid-template-columns:repeat(auto-fill,minmax(min(100%,380px),1fr));margin:16px 0}
figure svg{display:block;width:100%;height:auto}
.pairs{grid-template-columns:repeat(auto-fill,minmax(min(100%,520px),1fr))}
.table{overflow-x:auto}
table{border-collapse:collapse;font-variant-numeric:tabular-nums;white-space:nowrap;width:100%}
th,td{padding:4px 10px;text-align:right}th{color:var(--muted);font-weight:600}
th:first-child,td:first-child{text-align:left;position:sticky;left:0;background:var(--card)}
th.name,td.name{text-align:left}
td.text,th.text{white-space:normal;text-align:left;min-width:22ch}
pre{padding:8px 12px;font:12px/1.5 ui-monospace,monospace}
tr.new td{border-top:1px solid var(--border)}
@media print{:root{color-scheme:light;--page:#fff;--card:#fff;--ink:#000;--muted:#333;--border:#bbb}
body{max-width:none;padding:0;font-size:11px}p{max-width:none}
figure,tr,pre{break-inside:avoid}h2{break-after:avoid}figure,.table{border-radius:0}
.figures{grid-template-columns:1fr 1fr}.table{overflow:visible}
table{font-size:8px;white-space:normal}th,td{padding:2px 4px}pre{white-space:pre-wrap}}
)";

}  // namespace

std::string page_document(const std::string& title, const std::string& intro,
                          const std::vector<Plot>& figures, const std::string& body, const std::string& made,
                          bool pairs) {
  std::string html =
      "<!doctype html>\n<html lang='en'>\n<head>\n<meta charset='utf-8'>\n"
      "<meta name='viewport' content='width=device-width, initial-scale=1'>\n";
  html += fmt::format("<title>{}</title>\n<style>{}{}</style>\n</head>\n<body>\n", markup_escaped(title),
                      kPageStyle, plot_style());
  html += fmt::format("<h1>{}</h1>\n<p>{}</p>\n<div class='figures{}'>\n", markup_escaped(title),
                      markup_escaped(intro), pairs ? " pairs" : "");
  for (const Plot& plot : figures) html += fmt::format("<figure>{}</figure>\n", plot_in_page(plot));
  html += "</div>\n" + body;
  html +=
      fmt::format("<h2>Provenance</h2>\n<pre class='table' tabindex='0'>{}</pre>\n", markup_escaped(made));
  return html + "</body>\n</html>\n";
}

}  // namespace palpate

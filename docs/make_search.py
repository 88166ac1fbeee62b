#!/usr/bin/python3
"""Makes one HTML file of all pages of docs/, with a search: no server, nothing loaded from elsewhere.

Usage: make_search.py OUT.html

A section is what stands below a heading. A search shows the sections that have all words, those with a word in their
heading first. Needs Debian's python3-markdown.
"""
import base64
import html
import mimetypes
import pathlib
import posixpath
import re
import sys

import markdown

DOCS = pathlib.Path(__file__).resolve().parent
HEADING = re.compile(r"^(#{1,4}) (.+)$", re.MULTILINE)
LINK = re.compile(r'href="([^"]*)"')
PICTURE = re.compile(r'src="([^"]*)"')

STYLE = """
:root { --ink: #1c2330; --soft: #667085; --line: #e4e7ec; --blue: #1f6feb; }
body { margin: 0; font: 15px/1.55 "Inter", "DejaVu Sans", system-ui, sans-serif; color: var(--ink); background: #f6f7f9; }
header { position: sticky; top: 0; background: #fff; border-bottom: 1px solid var(--line); padding: 12px 24px; }
input { width: min(640px, 90%); font: inherit; padding: 8px 12px; border: 1px solid #98a2b3; border-radius: 8px; }
#count { color: var(--soft); margin-left: 12px; }
main { max-width: 1080px; margin: 0 auto; padding: 16px 24px 64px; }
section { background: #fff; border: 1px solid var(--line); border-radius: 10px; padding: 12px 22px; margin: 12px 0; }
section[hidden] { display: none; }
.page { color: var(--soft); font-size: 13px; }
h1, h2, h3, h4 { margin: 4px 0 8px; }
pre, code { font: 13px "DejaVu Sans Mono", ui-monospace, monospace; background: #f1f3f6; border-radius: 4px; }
pre { padding: 10px 12px; overflow-x: auto; }
table { border-collapse: collapse; font-size: 13.5px; display: block; overflow-x: auto; }
th, td { border-bottom: 1px solid var(--line); padding: 4px 10px 4px 0; text-align: left; vertical-align: top; }
a { color: var(--blue); }
img { max-width: 100%; }
"""

SCRIPT = """
const field = document.querySelector('input'), count = document.querySelector('#count'), main = document.querySelector('main');
const all = [...document.querySelectorAll('section')].map((node, order) => ({
  node, order, title: node.querySelector('h1,h2,h3,h4').textContent.toLowerCase(), text: node.textContent.toLowerCase()}));
function search() {
  const words = field.value.toLowerCase().split(/\\s+/).filter(word => word);
  const rank = one => words.reduce((sum, word) => sum + (one.title.includes(word) ? 1 : 0), 0);
  const found = all.filter(one => words.every(word => one.text.includes(word)));
  found.sort((a, b) => rank(b) - rank(a) || a.order - b.order);
  for (const one of all) one.node.hidden = true;
  for (const one of found) { one.node.hidden = false; main.append(one.node); }
  count.textContent = words.length ? `${found.length} sections` : `${all.length} sections`;
}
function show(id) {
  const target = document.getElementById(id);
  if (!target) return;
  field.value = '';
  search();
  target.scrollIntoView();
}
field.addEventListener('input', search);
window.addEventListener('hashchange', () => show(decodeURIComponent(location.hash.slice(1))));
search();
if (location.hash) show(decodeURIComponent(location.hash.slice(1)));
field.focus();
"""


def slug(title):
    """As code hosts make anchors of headings."""
    return re.sub(r"[^\w\- ]", "", title.replace("`", "").lower()).strip().replace(" ", "-")


def page_id(page):
    return page.replace("/", "-").removesuffix(".md")


def sections(text):
    """(heading, anchor, Markdown with its heading) of each; what looks like a heading inside of code is none."""
    code = [match.span() for match in re.finditer(r"^```.*?^```", text, re.DOTALL | re.MULTILINE)]
    starts = [match for match in HEADING.finditer(text) if not any(a <= match.start() < b for a, b in code)]
    for match, after in zip(starts, [*starts[1:], None]):
        yield match.group(2), slug(match.group(2)), text[match.start():after.start() if after else len(text)]


def inner_link(page, target, pages):
    """A link from one page to another leads to its section; others stay, as seen from docs/."""
    if "://" in target:
        return target
    path, _, anchor = target.partition("#")
    path = posixpath.normpath(posixpath.join(posixpath.dirname(page), path)) if path else page
    if path not in pages:
        return path
    return f"#{page_id(path)}" + (f"-{anchor}" if anchor else "")


def inner_picture(page, target):
    """The picture itself, so that it is in the one file."""
    file = (DOCS / page).parent / target
    if "://" in target or not file.is_file():
        return target
    return f"data:{mimetypes.guess_type(file)[0]};base64,{base64.b64encode(file.read_bytes()).decode()}"


def render(page, text, pages):
    parts = []
    for i, (heading, anchor, source) in enumerate(sections(text)):
        body = markdown.markdown(source, extensions=["tables", "fenced_code", "sane_lists"])
        body = LINK.sub(lambda match: f'href="{html.escape(inner_link(page, html.unescape(match.group(1)), pages))}"', body)
        body = PICTURE.sub(lambda match: f'src="{inner_picture(page, html.unescape(match.group(1)))}"', body)
        name = page_id(page)
        first = f'<a id="{name}"></a>' if i == 0 else ""
        parts.append(f'{first}<section id="{name}-{anchor}"><div class="page">{html.escape(page)}</div>{body}</section>')
    return "\n".join(parts)


def main():
    pages = {file.relative_to(DOCS).as_posix(): file.read_text() for file in sorted(DOCS.rglob("*.md"))}
    body = "\n".join(render(page, text, pages) for page, text in pages.items())
    pathlib.Path(sys.argv[1]).write_text(
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>takt: documentation</title><style>{STYLE}</style></head>'
        f'<body><header><input type="search" placeholder="Search {len(pages)} pages"><span id="count"></span></header>'
        f"<main>{body}</main><script>{SCRIPT}</script></body></html>\n")


if len(sys.argv) != 2:
    sys.exit(__doc__)
main()

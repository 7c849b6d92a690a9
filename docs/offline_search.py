"""Hook of mkdocs that lets the search box work in pages that are opened from disk.

Browsers refuse workers and requests for files of such pages. So the index is also written as a script, and the
script offline_search.js runs the search in a hidden frame.
"""

from pathlib import Path

SCRIPT = "search/offline_search.js"
INDEX = "search/search_index.js"


def on_post_page(output, page, config, **kwargs):
    depth = page.url.count("/")
    tags = "".join(f'<script src="{"../" * depth}{name}"></script>' for name in (INDEX, SCRIPT))
    return output.replace("</head>", tags + "</head>", 1)


def on_post_build(config, **kwargs):
    site = Path(config["site_dir"])
    index = (site / "search/search_index.json").read_text(encoding="utf-8")
    (site / INDEX).write_text(f"var __search = {{index: Promise.resolve({index})}};\n", encoding="utf-8")
    script = Path(__file__).with_name("offline_search.js").read_text(encoding="utf-8")
    (site / SCRIPT).write_text(script, encoding="utf-8")

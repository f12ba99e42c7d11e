//! Shared parts of written pages: frame, style, figures, charts, text. Pictures are separate files; nothing else is. No scripts.

pub mod chart;
pub mod text;

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A whole page: `head` is the text at the right of its header, followed by the sections.
pub fn page(title: &str, head: &str, sections: &[Markup]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "Lapidary: " (title) }
                style { (PreEscaped(include_str!("report/style.css"))) }
            }
            body {
                header { b { "Lapidary" } span { (head) } }
                @for section in sections { (section) "\n" }
            }
        }
    };
    page.into_string()
}

/// A section under a heading.
pub fn section(heading: &str, body: Markup) -> Markup {
    html! { section { h2 { (heading) } (body) } }
}

/// A picture that links to its file, with a caption; `class` may be empty.
pub fn figure(class: &str, file: &str, [width, height]: [u32; 2], alternative: &str, caption: Markup) -> Markup {
    html! {
        figure class=(class) {
            a href=(file) { img src=(file) width=(width) height=(height) alt=(alternative); }
            figcaption { (caption) }
        }
    }
}

/// A table: its header, and rows of equally many cells, of which the first names the row.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> Markup {
    html! {
        div.wide {
            table.figures {
                tr { @for cell in head { th { (cell) } } }
                @for row in rows { tr { @for cell in row { td { (cell) } } } }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_named_by_users_is_escaped() {
        let rows = [vec!["<b>scene</b>".to_owned(), "1".to_owned()]];
        let page = page("a & b", "head", &[section("x < y", table(&["Scene", "Nodes"], &rows))]);
        assert!(page.contains("a &amp; b") && page.contains("x &lt; y"), "{page}");
        assert!(page.contains("&lt;b&gt;scene&lt;/b&gt;") && !page.contains("<b>scene"));
        let figure = figure("", "a\"b.png", [4, 3], "", html! { "c" }).into_string();
        assert!(figure.contains("a&quot;b.png"), "{figure}");
    }
}

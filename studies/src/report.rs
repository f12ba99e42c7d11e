//! What all written pages share: frame, style, figures, charts, words. Pictures lie beside a page, all else is in it. No scripts.

pub mod chart;
pub mod text;

use text::escaped;

/// A whole page: what stands at the right of its head, and its sections in order.
pub fn page(title: &str, head: &str, sections: &[String]) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Lapidary: {}</title>\n<style>\n{}</style>\n\
         <header><b>Lapidary</b><span>{}</span></header>\n{}\n</html>\n",
        escaped(title),
        include_str!("report/style.css"),
        escaped(head),
        sections.join("\n")
    )
}

/// A section under a heading; `body` is HTML.
pub fn section(heading: &str, body: &str) -> String {
    format!("<section><h2>{}</h2>{body}</section>", escaped(heading))
}

/// A picture that links to its file, with a caption in HTML; `class` may be empty.
pub fn figure(class: &str, file: &str, [width, height]: [u32; 2], alternative: &str, caption: &str) -> String {
    let (file, alternative) = (escaped(file), escaped(alternative));
    format!(
        "<figure class=\"{class}\"><a href=\"{file}\"><img src=\"{file}\" width=\"{width}\" height=\"{height}\" \
         alt=\"{alternative}\"></a><figcaption>{caption}</figcaption></figure>"
    )
}

/// A table of figures: its head, and rows of as many cells, the first of which names the row. Cells are plain text.
pub fn table(head: &[&str], rows: &[Vec<String>]) -> String {
    let cells = |tag: &str, row: &mut dyn Iterator<Item = &str>| -> String {
        row.map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect()
    };
    let head = cells("th", &mut head.iter().copied());
    let row = |row: &Vec<String>| format!("<tr>{}</tr>", cells("td", &mut row.iter().map(String::as_str)));
    let rows: String = rows.iter().map(row).collect();
    format!("<div class=\"wide\"><table class=\"figures\"><tr>{head}</tr>{rows}</table></div>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_named_by_users_is_escaped() {
        let rows = [vec!["<b>scene</b>".to_owned(), "1".to_owned()]];
        let page = page("a & b", "head", &[section("x < y", &table(&["Scene", "Nodes"], &rows))]);
        assert!(page.contains("a &amp; b") && page.contains("x &lt; y"), "{page}");
        assert!(page.contains("&lt;b&gt;scene&lt;/b&gt;") && !page.contains("<b>scene"));
        assert!(figure("", "a\"b.png", [4, 3], "", "c").contains("a&quot;b.png"));
    }
}

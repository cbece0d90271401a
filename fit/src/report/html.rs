//! The page: HTML around the interactive figures, with plotly.js inside it once.

use std::fmt::Write;

use serde_json::{Value, json};

use super::drawing::{Curve, Drawing, DrawnAxis, POINTS_PER_SERIES, Stroke};
use super::figure::Figure;
use super::figures::capital;
use super::table::Table;
use super::{Page, Section};

/// plotly.js in its bundle for lines and bars, a quarter of the whole.
const PLOTLY_JS: &str = include_str!("../../assets/plotly-basic-3.0.1.min.js");
/// Points on the whole page at most: at 20 bytes each they take 0.44 MB beside the 1.03 MB of plotly.js.
const POINTS_PER_PAGE: usize = 22_000;
/// With very many series a page may grow past its 1.5 MB rather than show fewer points than this in each.
const LEAST_POINTS_PER_SERIES: usize = 400;
/// Tables of contents are for pages that do not show all their headings at a glance.
const SECTIONS_WITHOUT_CONTENTS: usize = 3;

/// Everything is inline, so everything else may be forbidden; `blob:` and `data:` images are the picture download.
const SECURITY_POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                               img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'";

const STYLE: &str = "
:root { color: #1a1a1a; background: #fff; font: 16px/1.5 system-ui, -apple-system, 'Segoe UI', sans-serif; }
body { max-width: 1100px; margin: 0 auto; padding: 1rem 1.5rem 2rem; }
h1 { font-size: 1.6rem; margin: .5rem 0 .8rem; }
h2 { font-size: 1.25rem; margin: 2rem 0 .5rem; border-bottom: 1px solid #ccc; }
h1, h2, figcaption, p { overflow-wrap: anywhere; }
p { max-width: 75ch; margin: .5rem 0; }
.lead { max-width: none; border-left: 5px solid #0072B2; background: #eef5fa; padding: .7rem 1rem; font-size: 1.1rem; }
nav ol { margin: .3rem 0; columns: 2; }
figure { margin: 1.2rem 0; break-inside: avoid; }
figcaption { font-weight: 600; }
.plot { height: 420px; }
.note { font-size: .9rem; color: #444; max-width: none; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: .3rem 0 1rem; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .8rem; text-align: left; vertical-align: top; border-bottom: 1px solid #ddd; }
td { white-space: nowrap; }
th { border-bottom: 2px solid #888; vertical-align: bottom; }
.number { text-align: right; }
.words { white-space: normal; min-width: 12rem; }
footer { margin-top: 2.5rem; border-top: 1px solid #ccc; padding-top: .5rem; font-size: .85rem; color: #444; }
code { font-family: ui-monospace, 'Cascadia Mono', Menlo, Consolas, monospace; overflow-wrap: anywhere; }
@media (max-width: 40rem) {
  body { padding: 1rem 1rem 2rem; }
  nav ol { columns: 1; }
  th, td { padding: .2rem .4rem; }
  /* A legend that has a name a row must leave room for the curves. */
  .plot { height: calc(420px + 20px * var(--names)); }
}
@media print {
  :root { font-size: 11pt; }
  body { max-width: none; padding: 0; }
  h2 { break-after: avoid; }
  tr { break-inside: avoid; }
  .scroll { overflow: visible; }
  .modebar { display: none; }
}
";

/// Paper is narrower than most windows, and plotly.js only follows the window.
const FIT_TO_PAPER: &str = "
for (const when of ['beforeprint', 'afterprint']) {
  window.addEventListener(when, () => {
    for (const plot of document.querySelectorAll('.plotly-graph-div')) {
      const width = when === 'beforeprint' ? 680 : plot.parentElement.clientWidth;
      Plotly.relayout(plot, { width, height: 420 }).then(() => {
        if (when === 'afterprint') Plotly.relayout(plot, { autosize: true, width: null, height: null });
      });
    }
  });
}
";

/// The whole file.
pub(super) fn render(page: &Page) -> String {
    let sections = page.sections.iter().filter(|s| s.has_content());
    let sections: Vec<&Section> = sections.collect();
    let figures = sections.iter().flat_map(|s| &s.figures);
    let most = most_points(figures.flat_map(|f| &f.series).map(|s| s.x.len()).collect());
    let has_figures = sections.iter().any(|s| !s.figures.is_empty());
    let title = escape(&page.title);

    let mut html = String::with_capacity(3 << 19);
    let _ = write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{SECURITY_POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n"
    );
    if has_figures {
        let _ = write!(html, "<script>{PLOTLY_JS}</script>");
    }
    let _ = write!(html, "\n</head>\n<body>\n<h1>{title}</h1>\n");
    if !page.lead.is_empty() {
        let _ = writeln!(html, "<p class=\"lead\">{}</p>", prose(&page.lead));
    }
    if has_figures {
        html.push_str("<noscript><p>The figures need JavaScript, which is in this file; nothing is loaded.</p></noscript>\n");
    }
    if sections.len() > SECTIONS_WITHOUT_CONTENTS {
        html.push_str("<nav aria-label=\"Contents\"><ol>\n");
        for (i, section) in sections.iter().enumerate() {
            let _ = writeln!(
                html,
                "<li><a href=\"#section-{}\">{}</a></li>",
                i + 1,
                escape(&section.heading)
            );
        }
        html.push_str("</ol></nav>\n");
    }
    let mut figure_number = 0;
    for (i, section) in sections.into_iter().enumerate() {
        let _ = writeln!(html, "<section id=\"section-{}\">", i + 1);
        section_body(&mut html, section, &mut figure_number, most);
        html.push_str("</section>\n");
    }
    if has_figures {
        let _ = writeln!(html, "<script>{FIT_TO_PAPER}</script>");
    }
    let _ = write!(html, "<footer>preslide {}", env!("CARGO_PKG_VERSION"));
    if !page.command.is_empty() {
        let _ = write!(html, " · made by <code>{}</code>", escape(&page.command));
    }
    html.push_str("</footer>\n</body>\n</html>\n");
    html
}

/// Points that a series may have, of all series' lengths: the short ones leave to the long what they do not need of the page's.
fn most_points(mut lengths: Vec<usize>) -> usize {
    lengths.sort_unstable();
    let mut left = POINTS_PER_PAGE;
    for (i, &length) in lengths.iter().enumerate() {
        let share = left / (lengths.len() - i);
        if length > share {
            return share.clamp(LEAST_POINTS_PER_SERIES, POINTS_PER_SERIES);
        }
        left -= length;
    }
    POINTS_PER_SERIES
}

fn section_body(html: &mut String, section: &Section, figure_number: &mut usize, most: usize) {
    if !section.heading.is_empty() {
        let _ = writeln!(html, "<h2>{}</h2>", escape(&section.heading));
    }
    for paragraph in &section.paragraphs {
        let _ = writeln!(html, "<p>{}</p>", prose(paragraph));
    }
    for table in section.tables.iter().filter(|table| !table.rows.is_empty()) {
        html.push_str(&table_html(table));
    }
    for figure in &section.figures {
        *figure_number += 1;
        html.push_str(&figure_html(figure, *figure_number, most));
    }
}

/// Characters from which on a cell is a sentence: its column is kept wide enough to be read.
const LONG: usize = 40;

fn table_html(table: &Table) -> String {
    let columns = table.columns();
    let is_long = |c: usize| {
        let mut cells = table.rows.iter().filter_map(|row| row.get(c));
        cells.any(|cell| cell.chars().count() > LONG)
    };
    let classes: Vec<&str> = (0..columns)
        .map(|c| match table.is_numeric(c) {
            true => " class=\"number\"",
            false if is_long(c) => " class=\"words\"",
            false => "",
        })
        .collect();
    let line = |cells: &[String], tag: &str| {
        let cells = (0..columns).map(|c| {
            let class = classes[c];
            format!(
                "<{tag}{class}>{}</{tag}>",
                escape(cells.get(c).map_or("", String::as_str))
            )
        });
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let mut html = String::from("<figure>\n");
    // Within the table a caption would widen it, and be cut where it scrolls.
    if !table.caption.is_empty() {
        let _ = writeln!(html, "<figcaption>{}</figcaption>", escape(&table.caption));
    }
    html.push_str("<div class=\"scroll\"><table>\n");
    if !table.head.is_empty() {
        let _ = writeln!(html, "<thead>{}</thead>", line(&table.head, "th"));
    }
    let rows: String = table.rows.iter().map(|row| line(row, "td")).collect();
    let _ = write!(html, "<tbody>\n{rows}</tbody>\n</table></div>\n</figure>\n");
    html
}

fn figure_html(figure: &Figure, number: usize, most: usize) -> String {
    let drawing = Drawing::new(figure, most);
    let mut html = String::from("<figure>\n");
    let caption = if figure.title.is_empty() {
        String::new()
    } else {
        format!(". {}", escape(&figure.title))
    };
    let _ = writeln!(html, "<figcaption>Figure {number}{caption}</figcaption>");
    let id = format!("figure-{number}");
    let names = drawing.curves.len();
    let plot = in_script(&plot(figure, &drawing));
    let _ = writeln!(
        html,
        "<div class=\"plot\" style=\"--names: {names}\"><div id=\"{id}\" class=\"plotly-graph-div\" style=\"height:100%; width:100%;\"></div>\n\
         <script>Plotly.newPlot(\"{id}\", {plot});</script></div>"
    );
    if !drawing.note.is_empty() {
        let _ = writeln!(html, "<p class=\"note\">{}</p>", prose(&drawing.note));
    }
    html.push_str("</figure>\n");
    html
}

/// What `Plotly.newPlot` draws.
fn plot(figure: &Figure, drawing: &Drawing) -> Value {
    let curves = &drawing.curves;
    let traces: Vec<Value> = curves.iter().map(|curve| trace(curve, drawing)).collect();
    json!({
        "data": traces,
        "layout": {
            "autosize": true,
            "font": {
                "family": "system-ui, -apple-system, 'Segoe UI', sans-serif",
                "size": 13,
                "color": "#1a1a1a",
            },
            "hovermode": "closest",
            // plotly.js's buttons stand in the first 40 pixels; what the legend needs at the bottom it adds itself.
            "margin": {"l": 70, "r": 20, "t": 40, "b": 55},
            "showlegend": curves.len() > 1,
            "legend": {"orientation": "h", "x": 0.0, "yref": "container", "y": 0.0, "yanchor": "bottom"},
            "xaxis": axis(&drawing.x),
            "yaxis": axis(&drawing.y),
        },
        "config": {
            "responsive": true,
            "displaylogo": false,
            "typesetMath": false,
            "plotlyServerURL": "",
            "toImageButtonOptions": {
                "format": "png",
                "filename": file_stem(&figure.title),
                "scale": 2,
            },
        },
    })
}

/// JSON that nothing in it can end the script of.
fn in_script(value: &Value) -> String {
    // Outside of strings JSON has none of these.
    let text = value.to_string();
    text.replace('&', "\\u0026")
        .replace('<', "\\u003c")
        .replace('>', "\\u003e")
        .replace('\'', "\\u0027")
}

fn axis(drawn: &DrawnAxis) -> Value {
    json!({
        "title": {"text": plotly_text(&drawn.title)},
        "type": if drawn.log { "log" } else { "linear" },
        // Over two decades plotly would label every digit, one on the other.
        "nticks": if drawn.log { 4 } else { 0 },
        "exponentformat": "power",
        "automargin": true,
        "showline": true,
        "mirror": true,
        "linecolor": "#444",
        "gridcolor": "#e4e4e4",
        "zerolinecolor": "#999",
    })
}

fn trace(curve: &Curve, drawing: &Drawing) -> Value {
    let colour = css(curve.rgb);
    let mode = match (curve.stroke.is_some(), curve.marks) {
        (true, true) => "lines+markers",
        (true, false) => "lines",
        (false, _) => "markers",
    };
    let dash = match curve.stroke {
        Some(Stroke::Dashed) => "dash",
        Some(Stroke::Dotted) => "dot",
        Some(Stroke::Solid) | None => "solid",
    };
    let values = |of: fn(&(f64, f64)) -> f64| -> Vec<f64> {
        curve.points.iter().map(|p| seven_digits(of(p))).collect()
    };
    let (x_unit, y_unit) = (plotly_text(&drawing.x.unit), plotly_text(&drawing.y.unit));
    json!({
        "type": "scatter",
        "name": plotly_text(&curve.name),
        "mode": mode,
        "x": values(|p| p.0),
        "y": values(|p| p.1),
        "line": {"color": colour, "width": curve.width, "dash": dash},
        "marker": {"color": colour, "size": if curve.width > 2.0 { 9 } else { 6 }},
        "hovertemplate": format!("%{{x:.5~g}} {x_unit}, %{{y:.5~g}} {y_unit}"),
    })
}

/// Rounded so that a point takes about 20 bytes of page; finer than any zoom on 4,000 points can show.
fn seven_digits(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// Text for HTML, attribute values included.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c => escaped.push(c),
        }
    }
    escaped
}

/// A note as a sentence, with its commands in their own type.
fn prose(text: &str) -> String {
    let stop = if text.ends_with(['.', ':', '!', '?']) {
        ""
    } else {
        "."
    };
    let text = escape(&capital(text));
    let parts = text.split('`').enumerate();
    let marked = parts.map(|(i, part)| match i % 2 {
        0 => part.to_owned(),
        _ => format!("<code>{part}</code>"),
    });
    marked.collect::<String>() + stop
}

/// Text for plotly.js, which reads tags and entities in labels.
fn plotly_text(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

fn css([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02X}{g:02X}{b:02X}")
}

/// A file name for the picture download.
fn file_stem(title: &str) -> String {
    let words: Vec<&str> = title
        .split(|c: char| !c.is_alphanumeric())
        .filter(|w| !w.is_empty())
        .collect();
    if words.is_empty() {
        "figure".into()
    } else {
        words.join("-").to_lowercase()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Axis, Series, Style};
    use super::*;

    fn line(name: &str, n: usize) -> Series {
        let x: Vec<f64> = (0..n).map(|i| i as f64 * 1e-3).collect();
        let y = x.iter().map(|x| (x * 7.0).sin() / 3.0).collect();
        Series::line(name, x, y)
    }

    fn figure(title: &str, series: Vec<Series>) -> Figure {
        Figure {
            series,
            ..Figure::new(title, Axis::new("time", "s"), Axis::new("force", "N"))
        }
    }

    fn page(sections: Vec<Section>) -> Page {
        Page {
            title: "Title".into(),
            lead: "Do this.".into(),
            command: "preslide demo".into(),
            sections,
        }
    }

    fn with_figures(figures: Vec<Figure>) -> Page {
        page(vec![Section {
            heading: "Fit".into(),
            figures,
            ..Section::default()
        }])
    }

    /// The page without plotly.js, whose text is not ours.
    fn own_text(page: &Page) -> String {
        render(page).replace(PLOTLY_JS, "")
    }

    #[test]
    fn plotly_js_is_embedded_once() {
        let html = render(&with_figures(vec![
            figure("a", vec![line("m", 9)]),
            figure("b", vec![line("m", 9)]),
        ]));
        assert_eq!(html.matches("plotly.js (basic - minified) v").count(), 1);
        assert!(html.len() < 1_050_000, "{}", html.len());
        assert!(
            !render(&page(vec![])).contains("plotly"),
            "a page without figures needs no plotly.js"
        );
    }

    #[test]
    fn each_figure_appears_once_in_order() {
        let html = own_text(&with_figures(vec![
            figure("first", vec![line("m", 9)]),
            figure("second", vec![]),
        ]));
        for (number, title) in [(1, "first"), (2, "second")] {
            assert_eq!(html.matches(&format!("id=\"figure-{number}\"")).count(), 1);
            assert_eq!(
                html.matches(&format!("Plotly.newPlot(\"figure-{number}\""))
                    .count(),
                1
            );
            assert_eq!(
                html.matches(&format!("Figure {number}. {title}<")).count(),
                1
            );
        }
    }

    #[test]
    fn nothing_of_ours_names_another_host() {
        let html = own_text(&with_figures(vec![figure(
            "a",
            vec![line("m", 9), line("n", 9)],
        )]));
        assert!(!html.contains("http:") && !html.contains("https:") && !html.contains("src="));
        assert!(html.contains("default-src 'none'"));
    }

    #[test]
    fn text_cannot_become_markup() {
        let evil = "</script><img src=x onerror=alert(1)> & \"quoted\"";
        let mut f = figure(evil, vec![line(evil, 9).style(Style::Dashed), line("b", 9)]);
        f.note = evil.into();
        f.x.label = evil.into();
        let table = Table {
            caption: evil.into(),
            head: vec![evil.into()],
            rows: vec![vec![evil.into()]],
        };
        let section = Section {
            heading: evil.into(),
            paragraphs: vec![evil.into()],
            tables: vec![table],
            figures: vec![f],
        };
        let html = own_text(&Page {
            title: evil.into(),
            lead: evil.into(),
            command: evil.into(),
            sections: vec![section],
        });
        assert!(!html.contains("<img"), "{html}");
        assert!(html.contains(
            "&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt; &amp; &quot;quoted&quot;"
        ));
    }

    #[test]
    fn gaps_are_null_in_the_data() {
        let mut series = line("m", 9);
        series.y[4] = f64::NAN;
        series.y[5] = f64::INFINITY;
        let html = own_text(&with_figures(vec![figure("a", vec![series])]));
        assert!(html.contains("null"));
        assert!(!html.contains("NaN") && !html.contains("inf,"));
    }

    #[test]
    fn a_long_recording_stays_below_a_megabyte_and_a_half() {
        let series = |f| (0..4).map(|i| line(&format!("{f}.{i}"), 60_000)).collect();
        let figures = (0..13)
            .map(|f| figure(&format!("f{f}"), series(f)))
            .collect();
        let html = render(&with_figures(figures));
        assert!(html.len() < 1_500_000, "{}", html.len());
        assert!(html.contains("of 60000 points a series"));
    }

    #[test]
    fn short_series_leave_their_points_to_long_ones() {
        assert_eq!(most_points(vec![60_000; 2]), POINTS_PER_SERIES);
        assert_eq!(most_points(vec![60_000; 11]), 2000);
        let mut many = vec![100; 20];
        many.extend([60_000; 10]);
        assert_eq!(most_points(many), 2000);
        assert_eq!(most_points(vec![60_000; 1000]), LEAST_POINTS_PER_SERIES);
    }

    #[test]
    fn a_legend_from_two_series_on_and_contents_from_four_sections_on() {
        assert!(
            own_text(&with_figures(vec![figure("a", vec![line("m", 9)])]))
                .contains("\"showlegend\":false")
        );
        let two = figure("a", vec![line("m", 9), line("n", 9)]);
        assert!(own_text(&with_figures(vec![two])).contains("\"showlegend\":true"));
        let sections = |n| {
            (0..n)
                .map(|i| Section {
                    heading: format!("h{i}"),
                    paragraphs: vec!["p".into()],
                    ..Section::default()
                })
                .collect()
        };
        assert!(!render(&page(sections(3))).contains("<nav"));
        assert!(render(&page(sections(4))).contains("<a href=\"#section-4\">h3</a>"));
    }

    #[test]
    fn a_note_gets_its_capital_its_full_stop_and_its_commands() {
        let html = prose("run `preslide <this>` first");
        assert_eq!(html, "Run <code>preslide &lt;this&gt;</code> first.");
        assert_eq!(prose("Done."), "Done.");
    }

    #[test]
    fn what_is_empty_has_no_heading() {
        let empty = Section {
            heading: "Empty".into(),
            tables: vec![Table::default()],
            ..Section::default()
        };
        assert!(!render(&page(vec![empty])).contains("Empty"));
    }

    #[test]
    fn the_footer_says_version_and_command() {
        let html = render(&page(vec![]));
        assert!(
            html.contains(concat!("preslide ", env!("CARGO_PKG_VERSION")))
                && html.contains("<code>preslide demo")
        );
    }
}

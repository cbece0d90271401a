//! Reports: what a command found, as one HTML page for people and as text tables.
//!
//! A [`Figure`] is described once, in SI units, and drawn in the page by plotly.js, which is embedded and saves a figure as PNG.
//!
//! ```no_run
//! use preslide_fit::report::{Axis, Figure, Page, Section, Series};
//!
//! let loops = Figure::new("Force–displacement", Axis::new("displacement", "m"), Axis::new("friction", "N"))
//!     .with(Series::line("measured", vec![0.0, 1e-5, 2e-5], vec![0.0, 0.5, 0.9]));
//! Page {
//!     title: "Identification".into(),
//!     lead: "Use GMS with four blocks.".into(),
//!     command: "preslide identify a.csv".into(),
//!     sections: vec![Section { heading: "Fit".into(), figures: vec!(loops), ..Section::default() }],
//! }
//! .write_html("report.html".as_ref())?;
//! # anyhow::Ok(())
//! ```

mod decimate;
mod drawing;
mod figure;
pub mod figures;
mod html;
mod scale;
mod table;
pub mod units;

pub use figure::{Axis, Colour, Emphasis, Figure, Series, Style};
pub use scale::{DisplayUnit, display_unit};
pub use table::{Columns, Table};

use std::path::Path;

use anyhow::Context;

/// One report: a recommendation first, then the sections that support it.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// Heading of the page and title of the browser's tab.
    pub title: String,
    /// The one recommendation that a person can act on; set in a box above everything else.
    pub lead: String,
    /// The command line that made the page, as typed; printed in the footer with the version.
    pub command: String,
    /// The body, parameters before figures; what is empty is left out. More than three sections get a table of contents.
    pub sections: Vec<Section>,
}

/// A heading with text, tables and figures, shown in that order.
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Heading, also the entry in the table of contents.
    pub heading: String,
    /// Plain text, one paragraph each, with commands between backticks; gets its capital and its full stop where it has none.
    pub paragraphs: Vec<String>,
    /// Tables, in order.
    pub tables: Vec<Table>,
    /// Figures, in order; numbered through the whole page.
    pub figures: Vec<Figure>,
}

impl Section {
    /// What is to be known beside the result: it stands last.
    pub fn notes(paragraphs: impl IntoIterator<Item = String>) -> Self {
        Section {
            heading: "Notes".into(),
            paragraphs: paragraphs.into_iter().collect(),
            ..Section::default()
        }
    }

    /// Whether it has anything below its heading.
    fn has_content(&self) -> bool {
        let rows = self.tables.iter().any(|table| !table.rows.is_empty());
        rows || !self.paragraphs.is_empty() || !self.figures.is_empty()
    }
}

impl Page {
    /// The page's HTML.
    pub fn to_html(&self) -> String {
        html::render(self)
    }

    /// Writes the page as one self-contained HTML file: scripts, styles and data are inside it, nothing is fetched
    /// (a content security policy in the page forbids it), and it opens from `file://`.
    ///
    /// plotly.js takes 1.03 MB of the file; the figures are decimated to keep the whole below 1.5 MB.
    ///
    /// # Errors
    /// When the file cannot be written; the message names it and says what to do.
    pub fn write_html(&self, path: &Path) -> anyhow::Result<()> {
        std::fs::write(path, html::render(self)).with_context(|| unwritable(path))
    }
}

/// The message when `path` cannot be written; the reason follows as the error's source.
fn unwritable(path: &Path) -> String {
    format!(
        "cannot write {}: name a file in a folder that exists and is writable",
        path.display()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn writing_into_a_missing_folder_names_the_file_and_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("absent").join("report.html");
        let error = format!("{:#}", Page::default().write_html(&path).unwrap_err());
        assert!(
            error.contains("report.html") && error.contains("folder that exists"),
            "{error}"
        );
    }
}

//! What the terminal shows.

use super::Screen;
use crate::words;
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::{Axis, Block, Chart, Dataset, GraphType, Paragraph, Wrap};

const KEYS: &str = "SPACE stop   e enable  d disable  a acknowledge   t move to  b move by  ←→ jog   h home  z zero   s set  w save   q quit";

impl Screen {
    pub(super) fn draw(&self, frame: &mut Frame) {
        let [top, plot, log, bottom] = Layout::vertical([
            Constraint::Length(9),
            Constraint::Min(8),
            Constraint::Length(6),
            Constraint::Length(3),
        ])
        .areas(frame.area());
        self.draw_state(frame, top);
        self.draw_error(frame, plot);
        let lines: Vec<Line> = self
            .lines
            .iter()
            .map(|line| Line::from(line.as_str()))
            .collect();
        frame.render_widget(
            Paragraph::new(lines).block(Block::bordered().title("log")),
            log,
        );
        let text = match self.question {
            Some(question) => format!("{} {}_", question.text(), self.typed),
            None => KEYS.to_owned(),
        };
        frame.render_widget(Paragraph::new(text).block(Block::bordered()), bottom);
    }

    fn draw_state(&self, frame: &mut Frame, area: Rect) {
        let identity = self.drive.identity();
        let colour = match (self.state.fault, self.is_enabled()) {
            (Some(_), _) => Color::Red,
            (None, true) => Color::Green,
            (None, false) => Color::Yellow,
        };
        let lines = words::state(&self.state, identity.count, identity.rate_hz, self.unit);
        let lines: Vec<Line> = lines.into_iter().map(Line::from).collect();
        let block = Block::bordered()
            .title("preslide drive")
            .border_style(Style::new().fg(colour).add_modifier(Modifier::BOLD));
        let text = Paragraph::new(lines)
            .wrap(Wrap { trim: false })
            .block(block);
        frame.render_widget(text, area);
    }

    /// The position error over the last samples.
    fn draw_error(&self, frame: &mut Frame, area: Rect) {
        let identity = self.drive.identity();
        let seconds = |tick: u32| f64::from(tick) / f64::from(identity.rate_hz.max(1));
        let last = self.samples.back().map_or(0, |sample| sample.tick);
        let error: Vec<(f64, f64)> = self
            .samples
            .iter()
            .map(|sample| {
                let counts = sample.reference as f64 / 65_536.0 - f64::from(sample.position);
                (
                    seconds(sample.tick) - seconds(last),
                    counts * identity.count * 1e9,
                )
            })
            .collect();
        let begin = error.first().map_or(-1.0, |point| point.0.min(-1e-3));
        let reach = error.iter().map(|point| point.1.abs()).fold(10.0, f64::max);
        let name = format!("reference less position, n{} over s", self.unit);
        let data = Dataset::default()
            .marker(Marker::Braille)
            .graph_type(GraphType::Line)
            .style(Style::new().fg(Color::Cyan))
            .data(&error);
        let time = Axis::default()
            .bounds([begin, 0.0])
            .labels([format!("{begin:.1}"), "0".to_owned()]);
        let value = Axis::default().bounds([-reach, reach]).labels([
            format!("{:.0}", -reach),
            "0".to_owned(),
            format!("{reach:.0}"),
        ]);
        let chart = Chart::new(vec![data])
            .block(Block::bordered().title(name))
            .x_axis(time)
            .y_axis(value);
        frame.render_widget(chart, area);
    }
}

//! The report page of a diagnosis: where first, then what and how sure, then what the recording cannot show.

use super::axis::Axis;
use super::curve::Curve;
use super::effect;
use super::lack::Lack;
use super::named::Name;
use super::place::{Place, means_over};
use super::second_position::{Lead, Periodic, SecondPosition};
use super::term::Subject;
use super::unnamed::Happened;
use super::verdict::Diagnosis;
use preslide_fit::recording::Recording;
use preslide_fit::report::figures::{between, capital, quantity, range, times};
use preslide_fit::report::units::symbol;
use preslide_fit::report::{self, Colour, Emphasis, Figure, Page, Section, Series, Style, Table};
use preslide_fit::statistics::{bounds, quantile_between_ranks};

/// Points of a figure's cloud.
const POINTS: usize = 6000;
/// Stretches of a map, each way.
const CELLS: usize = 24;
/// Parts of the line over one period.
const PERIOD: usize = 72;

impl SecondPosition {
    /// The difference over the travel and over each period, for the page.
    pub fn figures(&self, recording: &Recording) -> Vec<Figure> {
        let smooth = self.lead.as_ref().map(|l| self.smooth_figure(l, recording));
        let periodic = self.periodic.iter();
        let periodic = periodic.map(|p| self.periodic_figure(p, recording));
        smooth.into_iter().chain(periodic).collect()
    }

    fn smooth_figure(&self, lead: &Lead, recording: &Recording) -> Figure {
        let (x, y) = lead.curve.iter().map(|[x, d]| (*x, *d)).unzip();
        let unit = recording.position_unit();
        Figure::new(
            format!("`{}` less the position", self.column),
            report::Axis::new("position", unit),
            report::Axis::new("difference", unit),
        )
        .with(Series::line("lead error", x, y).colour(Colour::Blue))
    }

    fn periodic_figure(&self, found: &Periodic, recording: &Recording) -> Figure {
        let unit = recording.position_unit();
        let period = found.period.value;
        let x: Vec<f64> = (0..=PERIOD)
            .map(|k| period * k as f64 / PERIOD as f64)
            .collect();
        let y = x.iter().map(|x| found.at(*x)).collect();
        let (place, mean) = found.folded.iter().map(|[x, d]| (*x, *d)).unzip();
        Figure::new(
            format!(
                "`{}` less the position, over a period of {}",
                self.column,
                quantity(period, unit)
            ),
            report::Axis::new("position within the period", unit),
            report::Axis::new("difference", unit),
        )
        .with(Series::points("mean there", place, mean).colour(Colour::Sky))
        .with(Series::line("periodic lead error", x, y).colour(Colour::Blue))
    }
}

impl Diagnosis {
    /// The report page.
    pub fn page(&self, recording: &Recording, command: String) -> Page {
        Page {
            title: format!("Diagnosis of {}", recording.name),
            lead: format!(
                "{}. {}",
                capital(&self.verdict_clause(recording, false)),
                self.recommendation(recording)
            ),
            command,
            sections: [self.budget_section(recording)]
                .into_iter()
                .chain(self.given_section(recording))
                .chain(self.fit_section(recording))
                .chain([self.located(recording), self.missing_section(recording)])
                .chain(self.second_position(recording))
                .chain([
                    self.maps(recording),
                    Section {
                        heading: "What this recording cannot show".to_owned(),
                        paragraphs: self.lacks.iter().map(Lack::words).collect(),
                        ..Section::default()
                    },
                ])
                .collect(),
        }
    }

    /// The user's model as it stands and refitted.
    fn given_section(&self, recording: &Recording) -> Option<Section> {
        Some(Section {
            heading: "Your model".to_owned(),
            paragraphs: vec![self.given_words(recording)?],
            tables: self.given_table(recording).into_iter().collect(),
            ..Section::default()
        })
    }

    /// What explains the mismatch, and how much of it.
    fn budget_section(&self, recording: &Recording) -> Section {
        let besides = [self.in_fit_words(recording), self.possible_words(recording)];
        Section {
            heading: "What explains the mismatch".to_owned(),
            paragraphs: self
                .remarks(recording)
                .into_iter()
                .chain(besides.into_iter().flatten())
                .collect(),
            tables: vec![self.budget_table(recording)],
            ..Section::default()
        }
    }

    /// The fit that every command reports.
    fn fit_section(&self, recording: &Recording) -> Option<Section> {
        Some(Section {
            heading: "The fit".to_owned(),
            paragraphs: vec![self.fit_words(recording)?],
            ..Section::default()
        })
    }

    /// What second measurements of the position say.
    fn second_position(&self, recording: &Recording) -> Option<Section> {
        let all = &self.second_positions;
        (!all.is_empty()).then(|| Section {
            heading: "The second position".to_owned(),
            paragraphs: all.iter().map(|p| p.words(recording)).collect(),
            figures: all.iter().flat_map(|p| p.figures(recording)).collect(),
            ..Section::default()
        })
    }

    /// The coordinate that organises the mismatch, whether it flips with direction, and where it is.
    fn organiser(&self) -> (Axis, bool, Option<Place>) {
        if let Some(first) = self.missing().next() {
            let own = first.places.first();
            let axis = own.map_or(Axis::SinceReversal, |p| p.axis);
            let odd = self.organised.iter().find_map(|o| match o.term.subject {
                Subject::Curve(Curve { axis: a, odd }) if a == axis => Some(odd),
                _ => None,
            });
            // A force that does not flip is not drawn flipped, whichever curve organises the mismatch.
            let flips = self.flips(axis, &first.force);
            return (axis, flips && odd.unwrap_or(false), own.copied());
        }
        if let Some(unknown) = self.nameless().find(|u| u.happened.is_none()) {
            return (unknown.axis, unknown.odd, unknown.place);
        }
        let best = self.organised.iter().find_map(|o| match o.term.subject {
            Subject::Curve(curve) => Some(curve),
            _ => None,
        });
        best.map_or((Axis::Position, false, None), |c| (c.axis, c.odd, None))
    }

    /// One picture and one sentence: where recording and model differ, before and after.
    fn located(&self, recording: &Recording) -> Section {
        let (axis, odd, place) = self.organiser();
        let mut paragraphs: Vec<String> = self
            .missing()
            .map(|e| self.sentence(e, recording))
            .collect();
        let nameless = self.nameless().map(|u| u.words(self, recording));
        paragraphs.extend(nameless.map(|words| format!("Without a name: {words}")));
        if paragraphs.is_empty() {
            paragraphs.push("No stretch of any coordinate stands out from the noise.".to_owned());
        }
        let event = self.unnamed.iter().find_map(|u| u.happened.as_ref());
        let alone = event.is_some()
            && self.missing().next().is_none()
            && self.nameless().all(|u| u.happened.is_some());
        let first = self.mismatch_over(axis, odd, place, recording);
        let figures = first.filter(|_| !alone).into_iter();
        let figures = figures
            .chain(event.map(|e| self.mismatch_with(e, recording)))
            .collect();
        let reproduced = self.reproduced.as_ref().map(|r| r.words(recording));
        let notes = reproduced.into_iter().chain(recording.per_unit());
        paragraphs.extend(notes.map(|words| format!("Note: {words}")));
        Section {
            heading: "Where model and recording differ".to_owned(),
            paragraphs,
            figures,
            ..Section::default()
        }
    }

    /// The mismatch over time with all that happened, which is left out of every other figure.
    fn mismatch_with(&self, happened: &Happened, recording: &Recording) -> Figure {
        let [time, mismatch] = &happened.mismatch;
        let (low, high) = bounds(mismatch);
        let marks = |[from, to]: &[f64; 2]| [*from, *from, *to, *to, f64::NAN];
        let x = happened.times.iter().flat_map(marks).collect();
        let y = happened
            .times
            .iter()
            .flat_map(|_| [low, high, high, low, f64::NAN]);
        let mut figure = Figure::new(
            "Mismatch over time, with what happened",
            report::Axis::new("time", "s"),
            report::Axis::new("measured − model", unit_of(recording)),
        )
        .with(
            Series::points("every row", thin(time), thin(mismatch))
                .colour(Colour::Sky)
                .emphasis(Emphasis::Faint),
        )
        .with(
            Series::line("what happened", x, y.collect())
                .style(Style::Dashed)
                .colour(Colour::Black),
        );
        figure.note = "What lies between dashed lines is left out everywhere else.".to_owned();
        figure
    }

    /// Mean mismatch over a coordinate before and after, the place marked.
    fn mismatch_over(
        &self,
        axis: Axis,
        odd: bool,
        place: Option<Place>,
        recording: &Recording,
    ) -> Option<Figure> {
        let rows = &self.null.rows;
        let (x_unit, f_unit) = (axis.unit(recording.position_unit()), unit_of(recording));
        let values = rows.weak.at_centres(&axis.values(&rows.s)?);
        let direction = rows.weak.at_centres(&rows.s.direction);
        let residuals = &self.mismatch;
        let signed = |r: &[f64]| -> Vec<f64> {
            let along = r.iter().zip(&direction);
            along.map(|(r, d)| if odd { r * d } else { *r }).collect()
        };
        let [before, after] = [signed(&residuals[0]), signed(&residuals[1])];
        let means = [means_over(&values, &before), means_over(&values, &after)];
        let name = axis.name(&rows.s);
        let mut figure = Figure::new(
            format!("Mismatch over {name}"),
            report::Axis::new(name.as_str(), x_unit.as_str()),
            report::Axis::new(
                if odd {
                    "measured − model, along the motion"
                } else {
                    "measured − model"
                },
                f_unit,
            ),
        )
        .with(
            Series::points("every row, before", thin(&values), thin(&before))
                .colour(Colour::Sky)
                .emphasis(Emphasis::Faint),
        )
        .with(
            Series::line("mean before", means[0].0.clone(), means[0].1.clone())
                .colour(Colour::Blue)
                .emphasis(Emphasis::Strong),
        )
        .with(
            Series::line("mean after", means[1].0.clone(), means[1].1.clone())
                .colour(Colour::Vermillion)
                .emphasis(Emphasis::Strong),
        );
        if let Some(place) = place {
            let (low, high) = (
                quantile_between_ranks(&before, 0.002),
                quantile_between_ranks(&before, 0.998),
            );
            let x = vec![place.from, place.from, f64::NAN, place.to, place.to];
            let y = vec![low, high, f64::NAN, low, high];
            figure = figure.with(
                Series::line("place", x, y)
                    .style(Style::Dashed)
                    .colour(Colour::Black),
            );
            figure.note = format!(
                "The dashed lines mark where it has more than {} of its largest force: {}.",
                if self.missing().next().is_some() {
                    "a fifth"
                } else {
                    "half"
                },
                between(place.from, place.to, &x_unit)
            );
        }
        Some(figure)
    }

    /// The ranked names with how sure and why not the others.
    fn missing_section(&self, recording: &Recording) -> Section {
        let rows = &self.null.rows;
        let evidence = self.effects.iter().map(|e| {
            let Some(report) = &e.report else {
                let soft = matches!(e.name, Name::Hysteresis).then(|| self.too_soft()).flatten();
                return format!(
                    "{} ({}): {}. It would explain {:.1} % of what is left, at {:.1} standard errors.",
                    capital(&e.called(recording)), e.level(), soft.unwrap_or_else(|| e.name.words().to_owned()), 100.0 * e.evidence.share, e.evidence.z
                );
            };
            let tried: Vec<String> = report
                .tried
                .iter()
                .map(|(key, ratio)| {
                    let name = effect::by_id(key).map_or(key.as_str(), |e| e.name());
                    format!("{name} {}", times(*ratio))
                })
                .collect();
            format!(
                "{} ({}): {}. It explains {:.1} % of what is left without it, on stretches that its fit has not seen, at {:.1} standard errors over {:.0} stretches. Of its share others in its place explain: {}. To decide: {}.",
                capital(&e.called(recording)), e.level(), e.name.words(), 100.0 * e.evidence.share, e.evidence.z, e.evidence.blocks,
                if tried.is_empty() { "nothing comparable".to_owned() } else { tried.join(", ") },
                e.name.experiment()
            )
        });
        let intro = format!(
            "NMSE is the squared error over the variance of the whole measured effort after averaging with a kernel of ±{}; test figures come from {} stretches of the recording held out in turn. Decisions compare {} stretches with equal shares of the moving time and of the path. Rest ({:.0} % of the samples) and the beginning of each recording, until friction's state is known, are left out.",
            quantity(rows.weak.half_width_s, "s"),
            rows.weak.folds.len(),
            rows.blocks.len(),
            100.0 * rows.at_rest
        );
        Section {
            heading: "What is missing".to_owned(),
            paragraphs: std::iter::once(intro).chain(evidence).collect(),
            tables: vec![self.table(recording)],
            figures: vec![self.loops(recording)],
        }
    }

    fn loops(&self, recording: &Recording) -> Figure {
        let rows = &self.null.rows;
        let residuals = &self.mismatch;
        let position = rows.weak.at_centres(&rows.s.x);
        let shown = rows.weak.folds.last().cloned().unwrap_or(0..0);
        let modelled = |i: usize| -> Vec<f64> {
            let of = rows.force[shown.clone()]
                .iter()
                .zip(&residuals[i][shown.clone()]);
            of.map(|(f, r)| f - r).collect()
        };
        let x = position[shown.clone()].to_vec();
        Figure::new(
            "Force–displacement loops of the last stretch",
            report::Axis::new("position", recording.position_unit()),
            report::Axis::new("effort, averaged", unit_of(recording)),
        )
        .with(
            Series::line("measured", x.clone(), rows.force[shown.clone()].to_vec())
                .colour(Colour::Black),
        )
        .with(
            Series::line("model", x.clone(), modelled(0))
                .style(Style::Dashed)
                .colour(Colour::Sky),
        )
        .with(
            Series::line("extended model", x, modelled(1))
                .emphasis(Emphasis::Strong)
                .colour(Colour::Vermillion),
        )
    }

    /// Maps of the mismatch over position × velocity and over time, and the free curves.
    fn maps(&self, recording: &Recording) -> Section {
        let s = &self.null.rows.s;
        let organised = self.organised.iter().take(8).map(|o| {
            vec![
                o.term.subject.name(s),
                format!("{:.1}", 100.0 * o.evidence.share),
                format!("{:.1}", o.evidence.z),
            ]
        });
        let over_time = self.mismatch_over(Axis::Time, false, None, recording);
        let others = [Axis::Position, Axis::Velocity, Axis::SinceReversal]
            .into_iter()
            .filter_map(|axis| self.mismatch_over(axis, false, None, recording));
        Section {
            heading: "Maps of what is left".to_owned(),
            paragraphs: vec!["Structure in these plots is physics that the model lacks.".to_owned()],
            tables: vec![
                Table {
                    caption: "Free curves over one coordinate: what they predict of the mismatch on stretches held out".to_owned(),
                    head: ["curve", "share %", "z"].map(String::from).to_vec(),
                    rows: organised.collect(),
                },
                self.largest_cells(recording),
            ],
            figures: over_time.into_iter().chain(others).collect(),
        }
    }

    /// The cells of position × velocity in which the mean mismatch is largest, before and after.
    fn largest_cells(&self, recording: &Recording) -> Table {
        let rows = &self.null.rows;
        let (x, v) = (
            rows.weak.at_centres(&rows.s.x),
            rows.weak.at_centres(&rows.s.v),
        );
        let (bx, bv) = (bounds(&x), bounds(&v));
        let cell = |value: f64, (low, high): (f64, f64)| {
            let u = (value - low) / (high - low).max(1e-300);
            ((u * CELLS as f64) as usize).min(CELLS - 1)
        };
        let [before, after] = &self.mismatch;
        let mut sums = vec![(0.0, 0.0, 0usize); CELLS * CELLS];
        for i in 0..x.len() {
            let sum = &mut sums[cell(x[i], bx) * CELLS + cell(v[i], bv)];
            *sum = (sum.0 + before[i], sum.1 + after[i], sum.2 + 1);
        }
        let mut order: Vec<usize> = (0..sums.len()).filter(|c| sums[*c].2 > 2).collect();
        order.sort_by(|a, b| (sums[*b].0.abs()).total_cmp(&sums[*a].0.abs()));
        let edge = |i: usize, (low, high): (f64, f64)| low + (high - low) * i as f64 / CELLS as f64;
        let unit = recording.position_unit();
        let row = |c: usize| {
            let (i, j) = (c / CELLS, c % CELLS);
            let n = sums[c].2 as f64;
            vec![
                range(edge(i, bx), edge(i + 1, bx), unit),
                range(edge(j, bv), edge(j + 1, bv), &format!("{unit}/s")),
                quantity(sums[c].0 / n, unit_of(recording)),
                quantity(sums[c].1 / n, unit_of(recording)),
            ]
        };
        Table {
            caption: "Cells of position × velocity that hold most of the mismatch".to_owned(),
            head: ["position", "velocity", "mean before", "mean after"]
                .map(String::from)
                .to_vec(),
            rows: order.into_iter().take(6).map(row).collect(),
        }
    }
}

fn unit_of(recording: &Recording) -> &'static str {
    symbol(recording.effort_unit())
}

/// As many values as a cloud has points.
fn thin(values: &[f64]) -> Vec<f64> {
    let step = values.len().div_ceil(POINTS).max(1);
    values.iter().copied().step_by(step).collect()
}

//! Figures drawn from synthetic flights, and parsed as XML.

use roxmltree::{Document, Node, ParsingOptions};

use super::super::{ScoredStream, StreamMetrics};
use super::thin::POINTS_MAX;
use super::*;
use fusion::time::Time;

use flight::{FLIGHT, Flight, RADAR, Truth};

mod encounter;
mod flight;

fn drawn(evaluation: &Evaluation, truth: &Truth) -> Vec<Figure> {
    let lines: Vec<_> = truth.iter().map(|(id, points)| TruthLine { id, points }).collect();
    figures(evaluation, &lines, &Setting::default())
}

/// Checks that every figure and the page are well-formed, without invalid numbers.
fn checked(evaluation: &Evaluation, truth: &Truth) -> Vec<Figure> {
    let figures = drawn(evaluation, truth);
    let names: Vec<_> = figures.iter().map(|figure| figure.name).collect();
    assert_eq!(
        names,
        [
            "error-over-time",
            "error-over-range",
            "error-over-azimuth",
            "plan-view",
            "height-over-time",
            "error-distribution",
            "radar-tracks",
            "threshold",
            "registration-residuals"
        ]
    );
    for figure in &figures {
        well_formed(figure);
    }
    let html = page("A <test> & more", evaluation, &figures);
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(&html, options).expect("the page is also XML");
    assert!(!html.contains("NaN") && !html.contains(">inf"));
    figures
}

fn well_formed(figure: &Figure) {
    let document = Document::parse(&figure.svg).expect(figure.name);
    let text = |tag| document.root_element().children().find(|node: &Node| node.has_tag_name(tag));
    assert_eq!(text("title").unwrap().text(), Some(figure.title.as_str()));
    assert_eq!(text("desc").unwrap().text(), Some(figure.caption.as_str()));
    for node in document.descendants() {
        let attributes = node.attributes().map(|attribute| attribute.value());
        for text in attributes.chain(node.text()) {
            assert!(!text.contains("NaN") && text != "inf", "{}: {text}", figure.name);
        }
        let data = node.attribute("d").unwrap_or_default();
        assert!(!data.contains("inf"), "{}: {data}", figure.name);
    }
    assert!(figure.svg.len() < 1_500_000, "{}: {} octets", figure.name, figure.svg.len());
}

fn empty() -> Evaluation {
    let scored = Flight { drones: 0, ..FLIGHT }.scored(Vec::new(), 0.0);
    let scored = ScoredStream { all: StreamMetrics::default(), ..scored };
    Evaluation { drones: Vec::new(), fused: scored, radar: None, transponder: None }
}

#[test]
fn flight_gives_all_figures_deterministically() {
    let (evaluation, truth) = (FLIGHT.evaluation(), FLIGHT.truth());
    let figures = checked(&evaluation, &truth);
    assert_eq!(figures, drawn(&evaluation, &truth));
    assert_eq!(page("", &evaluation, &figures), page("", &evaluation, &figures));
    assert!(figures[0].svg.contains("Time since 2026-06-20 23:59:30 UTC (min)"));
}

#[test]
fn empty_evaluation_is_noted_in_every_figure() {
    for figure in checked(&empty(), &Vec::new()) {
        assert!(figure.svg.contains(">no point"), "{}", figure.name);
    }
    assert!(page("", &empty(), &[]).contains("Nothing can be told"));
}

#[test]
fn truth_alone_a_single_point_and_output_alone_are_drawn() {
    let truth = FLIGHT.truth();
    let figures = checked(&empty(), &truth);
    assert!(figures[3].svg.contains("true path") && figures[3].caption.contains("No site is known"));

    let mut single = Flight { radar: false, transponder: false, ..FLIGHT }.evaluation();
    single.fused.samples.truncate(1);
    checked(&single, &Vec::new());
    checked(&single, &truth);

    let output_only = Flight { radar: false, transponder: false, ..FLIGHT }.evaluation();
    let figures = checked(&output_only, &truth);
    assert!(!figures[0].svg.contains("radar plots"));
}

#[test]
fn the_plan_has_one_scale_and_the_radar_at_its_origin() {
    let (evaluation, truth) = (FLIGHT.evaluation(), FLIGHT.truth());
    let lines: Vec<_> = truth.iter().map(|(id, points)| TruthLine { id, points }).collect();
    let flat = flat::Flat::of(&streams(&evaluation), &lines);
    let (east, north) = flat.position(&RADAR).unwrap();
    assert!(flat.from_radar && east.hypot(north) < 2.0, "{east} {north}");

    // Grid lines are one step apart on both axes: the same number of pixels.
    let figure = &checked(&evaluation, &truth)[3];
    let document = Document::parse(&figure.svg).unwrap();
    let labels = |anchor, side: &str| -> Vec<(f64, f64)> {
        let texts = document.descendants().filter(|node| node.has_tag_name("text"));
        let of_axis =
            texts.filter(|node| node.parent_element().unwrap().attribute("text-anchor") == Some(anchor));
        of_axis
            .filter_map(|node| {
                let value = node.text()?.replace('\u{2212}', "-").replace(',', "").parse().ok()?;
                Some((value, node.attribute(side)?.parse().ok()?))
            })
            .collect()
    };
    let scale = |labels: &[(f64, f64)]| (labels[1].1 - labels[0].1) / (labels[1].0 - labels[0].0);
    let (east, north) = (scale(&labels("middle", "x")), scale(&labels("end", "y")));
    assert!(east > 0.0 && (east + north).abs() < 2e-3 * east, "{east} {north}");
}

#[test]
fn a_gap_of_the_truth_stays_a_gap() {
    let (evaluation, truth) = (FLIGHT.evaluation(), FLIGHT.truth());
    let figure = &checked(&evaluation, &truth)[4];
    let document = Document::parse(&figure.svg).unwrap();
    let paths = document.descendants().filter(|node| node.text() == Some(truth[0].0.as_str()));
    let data: Vec<_> = paths.filter_map(|node| node.parent_element()?.attribute("d")).collect();
    assert_eq!(data.len(), 1);
    assert_eq!(data[0].matches('M').count(), 2, "{}", data[0]);
}

#[test]
fn ids_are_escaped_and_stay_readable() {
    let (evaluation, truth) = (FLIGHT.evaluation(), FLIGHT.truth());
    let figures = checked(&evaluation, &truth);
    let html = page("", &evaluation, &figures);
    assert!(!html.contains("D0 <") && html.contains("<bdi>D0 &lt;&amp;&quot;&#39;&gt;</bdi>"));
    let document = Document::parse(&figures[3].svg).unwrap();
    assert!(document.descendants().any(|node| node.text() == Some("D0 <&\"'>")));
}

#[test]
fn non_finite_values_are_omitted() {
    let (mut evaluation, mut truth) = (FLIGHT.evaluation(), FLIGHT.truth());
    for scored in [&mut evaluation.fused, evaluation.radar.as_mut().unwrap()] {
        for (index, sample) in scored.samples.iter_mut().enumerate().take(60) {
            let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, f64::MAX][index % 5];
            match index % 7 {
                0 => sample.place.latitude_deg = bad,
                1 => sample.place.longitude_deg = bad,
                2 => sample.place.altitude_amsl_m = Some(bad),
                3 => sample.error.iter_mut().for_each(|error| error.east_m = bad),
                4 => sample.seen.iter_mut().for_each(|seen| seen.range_m = bad),
                5 => sample.seen.iter_mut().for_each(|seen| seen.azimuth_deg = bad),
                _ => sample.time = Time::from_nanos(if bad.is_nan() { i64::MIN } else { i64::MAX }),
            }
        }
    }
    truth[0].1[0].1.latitude_deg = f64::NAN;
    truth[1].1[0].1.altitude_amsl_m = Some(f64::INFINITY);
    checked(&evaluation, &truth);
}

#[test]
fn outliers_are_seen_and_hide_nothing() {
    let flight = Flight { outlier_every: 500, ..FLIGHT };
    let figures = checked(&flight.evaluation(), &flight.truth());
    assert!(figures[0].svg.contains(">1,000<") && figures[0].svg.contains(">1<"), "decades of both");
    assert!(figures[3].caption.contains("points lie outside"), "{}", figures[3].caption);
    assert!(!figures[3].svg.contains(">4,000<"));
}

#[test]
fn many_points_are_thinned_with_a_note_in_the_caption() {
    let flight = Flight { drones: 100, seconds: 600, ..FLIGHT };
    let figures = checked(&flight.evaluation(), &flight.truth());
    for figure in &figures[..5] {
        assert!(figure.caption.contains("nearly coincide"), "{}", figure.caption);
        let document = Document::parse(&figure.svg).unwrap();
        let marks = |node: Node<'_, '_>| node.attribute("d").map_or(0, |data| data.matches('M').count());
        assert!(document.descendants().map(marks).all(|marks| marks <= POINTS_MAX));
    }
}

#[test]
fn the_table_holds_the_scores() {
    let evaluation = FLIGHT.evaluation();
    let html = page("", &evaluation, &[]);
    for row in [
        "<th>PU (%)</th><td>97.43</td><td>70.17</td><td>97.88</td><td>+27.26 points</td>",
        "<th>mean ePos (m)</th><td>5.130</td><td>59.659</td><td>4.250</td><td>+91.4 %</td>",
        "<th>SEM ePos (m)</th><td>0.028</td><td>0.028</td><td>0.028</td><td>0.0 %</td>",
        "<th>GOSPA (m)</th><td>12,345.678</td>",
        "<th>precision of fusion (%)</th><td>98.76</td>",
    ] {
        assert!(html.contains(row), "{row} is missing in\n{html}");
    }
    assert!(!html.contains("ID changes (1/min)</th><td>"), "what no stream can tell has no row");
    assert_eq!(html.matches("<td>97.4</td><td>70.2</td>").count(), 2, "each drone's");
}

/// Threshold of the reference profile.
fn threshold() -> Threshold {
    Threshold::new(vec![(0.0, 60.0), (333.33, 60.0), (4333.33, 300.0)]).unwrap()
}

#[test]
fn plots_are_coloured_by_track_number() {
    let (evaluation, truth) = (FLIGHT.evaluation(), FLIGHT.truth());
    let figure = &checked(&evaluation, &truth)[6];
    assert!(figure.caption.contains(" plots of 3 tracks, numbers 0 to 999."), "{}", figure.caption);
    // Three track numbers: dark, middle, light; no colour of other numbers.
    let drawn =
        |colour: &str| figure.svg.matches(&format!("stroke=\"{colour}\" stroke-width=\"2.4\"")).count();
    let colours = ["#440154", "#472d7b", "#2c728e", "#5ec962", "#e3c51b"].map(drawn);
    assert_eq!(colours, [2, 0, 2, 2, 0], "from above and over time");
    assert!(figure.svg.contains("stroke-dasharray=\"1 2.4\"") && figure.svg.contains(">radar<"));
    let without_radar = Flight { radar: false, ..FLIGHT }.evaluation();
    assert!(checked(&without_radar, &truth)[6].caption.contains("There are no radar plots."));
}

#[test]
fn share_of_own_pairs_within_threshold_is_as_by_hand() {
    let (evaluation, truth) = (FLIGHT.evaluation(), FLIGHT.truth());
    let lines: Vec<_> = truth.iter().map(|(id, points)| TruthLine { id, points }).collect();
    let threshold = threshold();
    let setting = Setting { site: Some(RADAR), threshold: Some(&threshold), residuals: &[] };
    let figure = &figures(&evaluation, &lines, &setting)[7];
    well_formed(figure);
    let (plots, fixes) =
        (&evaluation.radar.as_ref().unwrap().samples, &evaluation.transponder.as_ref().unwrap().samples);
    let (mut pairs, mut within) = (0, 0);
    for plot in plots.iter().filter(|plot| plot.drone.is_some()) {
        let Some(fix) = fixes.iter().find(|fix| (fix.time, fix.drone) == (plot.time, plot.drone)) else {
            continue;
        };
        pairs += 1;
        let range = plot.place.offset_from(&RADAR).distance_m();
        within += usize::from(plot.place.offset_from(&fix.place).distance_m() <= threshold.at(range));
    }
    assert!(pairs > 1000 && within > pairs / 2 && within <= pairs);
    let said = format!(
        "Within the threshold: {} of {} pairs of one drone.",
        figure::counted(within),
        figure::counted(pairs)
    );
    assert!(figure.caption.contains(&said), "{said}\n{}", figure.caption);
    assert!(figure.svg.contains(">threshold D(ρ)<") && figure.svg.contains(">of two objects<"));
    assert!(
        figures(&evaluation, &lines, &Setting::default())[7].svg.contains("place of the radar is not known")
    );
}

#[test]
fn residual_figure_shows_the_applied_registration() {
    use super::super::{AngularResidual, PlotResidual, RadarResiduals};
    let residual = |azimuth_deg: f64, elevation_deg: f64| AngularResidual {
        azimuth_deg,
        elevation_deg,
        angle_deg: azimuth_deg.hypot(elevation_deg),
    };
    let plot = |index: u32| {
        let sway = f64::from(index % 2) - 0.5;
        PlotResidual {
            azimuth_deg: 40.0 + f64::from(index % 60),
            elevation_deg: 3.0 + f64::from(index % 7),
            before: residual(2.0 + sway, sway),
            after: residual(sway, sway),
        }
    };
    let radar = |id: &str, plots: u32| RadarResiduals {
        radar: id.to_owned(),
        tracks: 12.5,
        plots: (0..plots).map(plot).collect(),
    };
    let radars = [radar("a <&>", 4000), radar("b", 0)];
    let figure = residuals::registration(&radars);
    well_formed(&figure);
    let said = "a <&>: 4,000 plots, 12.5 tracks; angle between measured and true direction 2.12° before and 0.71° after \
        (root mean square); mean of azimuth and elevation 2.00° and 0.00° before, 0.00° and 0.00° after;";
    assert!(figure.caption.contains(said), "{}", figure.caption);
    assert!(figure.caption.contains("b: no plots.") && figure.svg.contains(">no point of a drone"));
    assert!(figure.svg.contains(">before<") && figure.svg.contains(">after<"));
}

//! Latency of reports: from the time of a report to its reception.

use super::subject::AssessedSubject;
use super::types::{AssessmentFigure, FigureTable};
use input::statistics::quantile;

/// Latency of a sensor's reports; `None` if the file does not state times of reception.
pub(super) fn latency(subject: &AssessedSubject<'_>) -> Option<FigureTable> {
    let mut delays: Vec<f64> = (subject.reports.iter())
        .filter_map(|report| Some(report.received?.seconds_since(report.point.time)))
        .collect();
    delays.sort_by(f64::total_cmp);
    let last = *delays.last()?;
    let count = delays.len() as u64;
    let early = delays.iter().filter(|delay| **delay < 0.0).count() as f64;
    let figure = |name: &str, label: &str, unit, digits, value| {
        let key = subject.figure_key(&format!("latency.{name}"));
        AssessmentFigure::plain(key, label, unit, digits, value).with_count(count)
    };
    let figures = vec![
        figure("p50", "median", "s", 3, quantile(&delays, 0.5)),
        figure("p95", "95 %", "s", 3, quantile(&delays, 0.95)),
        figure("p99", "99 %", "s", 3, quantile(&delays, 0.99)),
        figure("longest", "longest", "s", 3, Some(last)),
        figure("early", "reports stamped after their reception", "%", 2, Some(100.0 * early / count as f64)),
    ];
    Some(FigureTable { title: subject.title.clone(), figures })
}

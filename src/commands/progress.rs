//! Progress bar on a terminal; no output elsewhere.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Progress through `total` octets, or through an unknown number. Draws on standard error.
pub fn bar(total: Option<u64>) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(total, ProgressDrawTarget::stderr_with_hz(5));
    let template = if total.is_some() {
        "{bar:30} {percent:>3} %  {bytes}  {bytes_per_sec}  {eta} left  {msg}"
    } else {
        "{spinner} {bytes}  {bytes_per_sec}  {msg}"
    };
    bar.with_style(ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()))
}

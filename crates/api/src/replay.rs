//! `/api/v1/replay`: pauses, speeds up and moves a replay.

use axum::http::StatusCode;
use schemars::JsonSchema;
use serde::Serialize;

use super::problem::Problem;
use super::request::ApiRequest;
use fusion::time::{DAY, SECOND, Time};
use picture::Rfc3339;
use service::live::{Player, PlayerState, ReplayCommand};

/// Valid speeds, as multiples of real time.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// State of a replay.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "Replay")]
pub struct ReplayState {
    playing: bool,
    /// Speed, as a multiple of real time.
    speed: f64,
    ended: bool,
    /// Time of the slot shown last.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// Start of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<Rfc3339>,
    /// End of the recording; left out until it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    end: Option<Rfc3339>,
}

/// Resumes the replay.
pub fn play(request: &ApiRequest) -> Result<ReplayState, Problem> {
    order(request, ReplayCommand::Play)
}

/// Pauses the replay.
pub fn pause(request: &ApiRequest) -> Result<ReplayState, Problem> {
    order(request, ReplayCommand::Pause)
}

/// Moves the replay to a time, or to a time of day that occurs only once in the recording.
pub fn seek(request: &ApiRequest) -> Result<ReplayState, Problem> {
    let state = request.state.options.player.as_ref().map(Player::state);
    // Jiff would also find a time of day in a text with a date and an offset.
    let is_clock =
        |text: &&str| text.contains(':') && text.chars().all(|c| c.is_ascii_digit() || ":.".contains(c));
    let clock =
        request.query.text("time").filter(is_clock).and_then(|text| text.parse::<jiff::civil::Time>().ok());
    let to = match (state, clock) {
        (Some(state), Some(clock)) => on_its_day(clock, state)?,
        _ => {
            let first = state.and_then(|state| state.first).map(whole);
            let example = first.as_deref().unwrap_or("2026-03-14T09:00:00Z");
            let clock = example.get(11..19).unwrap_or("09:00:00");
            let rule = format!("write the time as RFC 3339 has it, {example}, or as a time of day, {clock}");
            request.query.time("time").ok().flatten().ok_or_else(|| Problem::parameter("time", rule))?
        }
    };
    order(request, ReplayCommand::Seek(to))
}

/// Time of the recording with this time of day, UTC.
fn on_its_day(clock: jiff::civil::Time, state: PlayerState) -> Result<Time, Problem> {
    let (Some(first), Some(last)) = (state.first, state.last) else {
        let detail = "how long the recording is, is not known yet: give the day, too, or try again";
        return Err(Problem::unavailable(detail, Vec::new()).retry_after_s(1));
    };
    let nanos = clock.duration_since(jiff::civil::Time::midnight()).as_nanos() as i64;
    // A user leaves out the fraction of the first second.
    let begin = first.nanos() - first.nanos().rem_euclid(SECOND);
    let to = begin + (nanos - first.since_midnight() / SECOND * SECOND).rem_euclid(DAY);
    let span = format!("the recording is from {first} to {last}");
    if to > last.nanos() {
        return Err(Problem::parameter("time", format!("{span}: it has no {clock}")));
    }
    if to + DAY <= last.nanos() {
        let day = whole(Time::from_nanos(to));
        return Err(Problem::parameter("time", format!("{span}: give the day of {clock}, too: {day}")));
    }
    Ok(Time::from_nanos(to))
}

/// Time rounded to the second.
fn whole(time: Time) -> String {
    let text = time.to_string();
    text.get(..19).map_or(text.clone(), |seconds| format!("{seconds}Z"))
}

/// Sets the speed.
pub fn speed(request: &ApiRequest) -> Result<ReplayState, Problem> {
    let rule = "a speed is 0.01 to 1000";
    let speed = request.query.value("speed", rule, |speed: &f64| SPEEDS.contains(speed))?;
    order(request, ReplayCommand::Speed(speed.ok_or_else(|| Problem::parameter("speed", rule))?))
}

/// State of the replay for `/api/v1/info`; `None` if the service is live.
pub fn state(player: Option<&Player>) -> Option<ReplayState> {
    player.map(|player| player.state().into())
}

fn order(request: &ApiRequest, order: ReplayCommand) -> Result<ReplayState, Problem> {
    let Some(player) = &request.state.options.player else {
        return Err(Problem::new(
            StatusCode::CONFLICT,
            "this is the live service: only a replay can be steered",
        ));
    };
    let mut state = player.state();
    // The order takes effect at the next slot. The answer contains the state after it.
    match order {
        ReplayCommand::Play => state.playing = true,
        ReplayCommand::Pause => state.playing = false,
        ReplayCommand::Speed(speed) => state.speed = speed,
        ReplayCommand::Seek(to) => state.time = Some(to),
    }
    player.order(order);
    Ok(state.into())
}

impl From<PlayerState> for ReplayState {
    fn from(state: PlayerState) -> Self {
        let PlayerState { playing, speed, time, first, last, ended } = state;
        let [time, start, end] = [time, first, last].map(|time| time.map(Rfc3339));
        Self { playing, speed, ended, time, start, end }
    }
}

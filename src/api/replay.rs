//! `/api/v1/replay`: a recording is paused, sped up, and taken to another time.

use axum::http::StatusCode;
use schemars::JsonSchema;
use serde::Serialize;

use super::ask::Ask;
use super::problem::Problem;
use crate::live::{Order, Player, PlayerState};
use crate::picture::Rfc3339;
use fusion::time::{DAY, SECOND, Time};

/// How many times faster than it happened.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// How a replay is.
#[derive(Serialize, JsonSchema)]
pub struct Replay {
    playing: bool,
    /// How many times faster than it happened.
    speed: f64,
    ended: bool,
    /// Of the slot shown last.
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Rfc3339>,
    /// Of the recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    start: Option<Rfc3339>,
    /// Of the recording; left out until it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    end: Option<Rfc3339>,
}

/// Go on.
pub fn play(ask: &Ask) -> Result<Replay, Problem> {
    order(ask, Order::Play)
}

/// Stop where it is.
pub fn pause(ask: &Ask) -> Result<Replay, Problem> {
    order(ask, Order::Pause)
}

/// Go to a time, or to the only moment of the recording with that time of day.
pub fn seek(ask: &Ask) -> Result<Replay, Problem> {
    let state = ask.state.options().player.as_ref().map(Player::state);
    // Jiff would find a time of day in a text with a day and an offset, too.
    let is_clock =
        |text: &&str| text.contains(':') && text.chars().all(|c| c.is_ascii_digit() || ":.".contains(c));
    let clock =
        ask.query.text("time").filter(is_clock).and_then(|text| text.parse::<jiff::civil::Time>().ok());
    let to = match (state, clock) {
        (Some(state), Some(clock)) => on_its_day(clock, state)?,
        _ => {
            let first = state.and_then(|state| state.first).map(whole);
            let example = first.as_deref().unwrap_or("2026-03-14T09:00:00Z");
            let clock = example.get(11..19).unwrap_or("09:00:00");
            let rule = format!("write the time as RFC 3339 has it, {example}, or as a time of day, {clock}");
            ask.query.time("time").ok().flatten().ok_or_else(|| Problem::parameter("time", rule))?
        }
    };
    order(ask, Order::Seek(to))
}

/// The moment of the recording with this time of day, UTC.
fn on_its_day(clock: jiff::civil::Time, state: PlayerState) -> Result<Time, Problem> {
    let (Some(first), Some(last)) = (state.first, state.last) else {
        let detail = "how long the recording is, is not known yet: give the day, too, or try again";
        return Err(Problem::unavailable(detail, Vec::new()).retry_after_s(1));
    };
    let nanos = clock.duration_since(jiff::civil::Time::midnight()).as_nanos() as i64;
    // A person leaves out fractions of the first second.
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

/// To the second, as a person writes it.
fn whole(time: Time) -> String {
    let text = time.to_string();
    text.get(..19).map_or(text.clone(), |seconds| format!("{seconds}Z"))
}

/// Go faster or slower.
pub fn speed(ask: &Ask) -> Result<Replay, Problem> {
    let rule = "a speed is 0.01 to 1000";
    let speed = ask.query.value("speed", rule, |speed: &f64| SPEEDS.contains(speed))?;
    order(ask, Order::Speed(speed.ok_or_else(|| Problem::parameter("speed", rule))?))
}

/// How the replay is, for `/api/v1/info`; `None` where the service is live.
pub fn state(player: Option<&Player>) -> Option<Replay> {
    player.map(|player| player.state().into())
}

fn order(ask: &Ask, order: Order) -> Result<Replay, Problem> {
    let Some(player) = &ask.state.options().player else {
        return Err(Problem::new(
            StatusCode::CONFLICT,
            "this is the live service: only a replay can be steered",
        ));
    };
    let mut state = player.state();
    // The order is done at the next slot: what it will be is told.
    match order {
        Order::Play => state.playing = true,
        Order::Pause => state.playing = false,
        Order::Speed(speed) => state.speed = speed,
        Order::Seek(to) => state.time = Some(to),
    }
    player.order(order);
    Ok(state.into())
}

impl From<PlayerState> for Replay {
    fn from(state: PlayerState) -> Self {
        let PlayerState { playing, speed, time, first, last, ended } = state;
        let [time, start, end] = [time, first, last].map(|time| time.map(Rfc3339));
        Self { playing, speed, ended, time, start, end }
    }
}

//! `/api/v1/replay`: a recording is paused, sped up, and taken to another time.

use axum::http::StatusCode;
use serde_json::{Value, json};

use super::ask::{Answer, Ask, JSON, json};
use super::history::time;
use super::problem::Problem;
use crate::live::{Order, Player, PlayerState};

/// How many times faster than it happened.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// Go on.
pub fn play(ask: &Ask) -> Answer {
    order(ask, Order::Play)
}

/// Stop where it is.
pub fn pause(ask: &Ask) -> Answer {
    order(ask, Order::Pause)
}

/// Go to a time.
pub fn seek(ask: &Ask) -> Answer {
    let to = time(ask, "time")?.ok_or_else(|| Problem::parameter("time", "it has to be given, RFC 3339"))?;
    order(ask, Order::Seek(to))
}

/// Go faster or slower.
pub fn speed(ask: &Ask) -> Answer {
    let rule = "a speed is 0.01 to 1000";
    let speed = ask.value("speed", rule, |speed: &f64| SPEEDS.contains(speed))?;
    order(ask, Order::Speed(speed.ok_or_else(|| Problem::parameter("speed", rule))?))
}

/// How the replay is, for `/api/v1/info`; `None` where the service is live.
pub fn state(player: Option<&Player>) -> Option<Value> {
    player.map(|player| shown(player.state()))
}

fn order(ask: &Ask, order: Order) -> Answer {
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
    json(JSON, &shown(state))
}

fn shown(state: PlayerState) -> Value {
    let mut shown = json!({ "playing": state.playing, "speed": state.speed, "ended": state.ended });
    let times = [("time", state.time), ("start", state.first), ("end", state.last)];
    for (name, time) in times {
        if let Some(time) = time {
            shown[name] = json!(time.to_string());
        }
    }
    shown
}

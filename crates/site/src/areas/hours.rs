//! Reads the times at which a zone applies.

use jiff::Timestamp;
use jiff::civil::{DateTime, Time as TimeOfDay, Weekday};
use jiff::tz::{Offset, TimeZone};

use super::member::Member;
use super::schedule::{Days, Hours, Period, time_of};
use fusion::time::Time;

/// A period with `startDateTime`, `endDateTime` and daily periods, which both formats share. `local` is the time zone of
/// times without an offset.
pub(super) fn period(member: &Member<'_>, local: Option<&TimeZone>) -> Result<Period, String> {
    member.knows_only(&["startDateTime", "endDateTime", "permanent", "schedule", "dailyPeriod"])?;
    let date = |name: &str| member.get(name).map(|date| instant(&date, local)).transpose();
    let (from, to) = (date("startDateTime")?, date("endDateTime")?);
    if from.zip(to).is_some_and(|(from, to)| from >= to) {
        return Err(member.refused("endDateTime has to be behind startDateTime"));
    }
    let mut read = Period { from, to, hours: Vec::new() };
    let daily = [member.get("schedule"), member.get("dailyPeriod")];
    for entry in daily.iter().flatten().flat_map(Member::entries) {
        match hours(&entry, local)? {
            Some(hours) => read.hours.push(hours),
            // All day on every day: the other daily periods add nothing.
            None => return Ok(Period { hours: Vec::new(), ..read }),
        }
    }
    Ok(read)
}

/// The hours of a daily period; `None`: all day on every day.
fn hours(member: &Member<'_>, local: Option<&TimeZone>) -> Result<Option<Hours>, String> {
    for name in ["startEvent", "endEvent"] {
        if let Some(event) = member.get(name) {
            return Err(event.refused(
                "hours of daylight are not worked out; write startTime and endTime, or remove the schedule: the zone then \
                 applies all day",
            ));
        }
    }
    member.knows_only(&["day", "startTime", "endTime"])?;
    let mut days = Days::default();
    for day in member.get("day").iter().flat_map(Member::entries) {
        days = match day.text()? {
            "MON" => days.with(Weekday::Monday),
            "TUE" => days.with(Weekday::Tuesday),
            "WED" => days.with(Weekday::Wednesday),
            "THU" => days.with(Weekday::Thursday),
            "FRI" => days.with(Weekday::Friday),
            "SAT" => days.with(Weekday::Saturday),
            "SUN" => days.with(Weekday::Sunday),
            "ANY" => Days::ALL,
            _ => return Err(day.refused("days are MON, TUE, WED, THU, FRI, SAT, SUN and ANY")),
        };
    }
    let days = if days == Days::default() { Days::ALL } else { days };
    let (start, end) = match (member.get("startTime"), member.get("endTime")) {
        (Some(start), Some(end)) => (start, end),
        (None, None) if days == Days::ALL => return Ok(None),
        (None, None) => {
            let midnight = TimeOfDay::midnight();
            return Ok(Some(Hours { days, start: midnight, end: midnight, zone: zone_of(member, local)? }));
        }
        _ => return Err(member.refused("hours have both startTime and endTime, or neither")),
    };
    let ((from, zone), (to, other)) = (time_of_day(&start, local)?, time_of_day(&end, local)?);
    if zone != other {
        return Err(end.refused("its time zone has to be that of startTime"));
    }
    Ok(Some(Hours { days, start: from, end: to, zone }))
}

/// A date with a time of day (RFC 3339).
pub(super) fn instant(member: &Member<'_>, local: Option<&TimeZone>) -> Result<Time, String> {
    const UNDERSTOOD: &str = "a date with time is understood, such as 2026-06-15T09:00:00Z";
    let text = member.text().map_err(|_| member.refused(UNDERSTOOD))?;
    if let Ok(timestamp) = text.parse::<Timestamp>() {
        return Ok(time_of(timestamp));
    }
    let civil: DateTime = text.parse().map_err(|_| member.refused(UNDERSTOOD))?;
    let zoned = civil.to_zoned(zone_of(member, local)?).map_err(|_| member.refused(UNDERSTOOD))?;
    Ok(time_of(zoned.timestamp()))
}

/// A time of day with its time zone; 24:00 is midnight.
fn time_of_day(member: &Member<'_>, local: Option<&TimeZone>) -> Result<(TimeOfDay, TimeZone), String> {
    let refused = || member.refused("a time of day is understood, such as 17:00:00Z or 17:00:00+02:00");
    let text = member.text().map_err(|_| refused())?;
    let (time, zone) = match text.find(['Z', 'z', '+', '-']) {
        Some(end) => (&text[..end], Some(&text[end..])),
        None => (text, None),
    };
    let zone = match zone {
        None => zone_of(member, local)?,
        Some("Z" | "z") => TimeZone::UTC,
        Some(offset) => TimeZone::fixed(offset_of(offset).ok_or_else(refused)?),
    };
    let is_midnight =
        |text: &str| text.strip_prefix("24:00").is_some_and(|rest| rest.chars().all(|c| ":.0".contains(c)));
    let time = if is_midnight(time) { TimeOfDay::midnight() } else { time.parse().map_err(|_| refused())? };
    Ok((time, zone))
}

/// The offset from UTC: `+02:00`, `+0200` or `+02`.
fn offset_of(text: &str) -> Option<Offset> {
    let (sign, digits) = (if text.starts_with('-') { -1 } else { 1 }, text[1..].replace(':', ""));
    let is_whole = digits.chars().all(|c| c.is_ascii_digit()) && matches!(digits.len(), 2 | 4);
    let number = |digits: &str| if digits.is_empty() { Some(0) } else { digits.parse::<i32>().ok() };
    let (hours, minutes) = if is_whole { digits.split_at(2) } else { return None };
    let (hours, minutes) = (number(hours)?, number(minutes).filter(|minutes| *minutes < 60)?);
    Offset::from_seconds(sign * (hours * 3600 + minutes * 60)).ok().filter(|_| hours < 24)
}

fn zone_of(member: &Member<'_>, local: Option<&TimeZone>) -> Result<TimeZone, String> {
    local.cloned().ok_or_else(|| {
        member.refused("it has no time zone; add time_zone = …, such as \"Europe/Zurich\", to this [[areas]]")
    })
}

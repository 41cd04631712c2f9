//! Dates and times of day in the column of times, as seconds since its first row.

use toml_datetime::{Date, Datetime, Offset, Time};

/// Nanoseconds of a second and of a day.
const SECOND: i128 = 1_000_000_000;
const DAY: i128 = 86_400 * SECOND;

/// What a moment is counted from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Origin {
    /// Universal time: a date and a time with their offset.
    Universal,
    /// A date, with or without a time, of an unknown place.
    Local,
    /// Midnight: a time of day.
    Midnight,
}

/// A moment, in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Moment {
    origin: Origin,
    nanoseconds: i128,
}

/// The moment in a cell: a date and time of ISO 8601 or RFC 3339 (`2024-05-01T12:00:00.5Z`, with a space for T, with
/// or without offset), a date, or a time of day; none for other texts, such as days before months.
pub(super) fn moment(text: &str) -> Option<Moment> {
    let Datetime { date, time, offset } = text.parse().ok()?;
    let days = date.map_or(0, |date| DAY * i128::from(days(date)));
    let within = time.map_or(0, nanoseconds);
    let (origin, east) = match (date, offset) {
        (None, _) => (Origin::Midnight, 0),
        (Some(_), None) => (Origin::Local, 0),
        (Some(_), Some(Offset::Z)) => (Origin::Universal, 0),
        (Some(_), Some(Offset::Custom { minutes })) => (Origin::Universal, 60 * SECOND * i128::from(minutes)),
    };
    Some(Moment { origin, nanoseconds: days + within - east })
}

fn nanoseconds(time: Time) -> i128 {
    let minutes = 60 * i64::from(time.hour) + i64::from(time.minute);
    let seconds = 60 * minutes + i64::from(time.second.unwrap_or(0));
    SECOND * i128::from(seconds) + i128::from(time.nanosecond.unwrap_or(0))
}

/// Days since 1 March of the year 0 in the Gregorian calendar: years that begin in March have their leap day last.
fn days(date: Date) -> i64 {
    let (month, day) = (i64::from(date.month), i64::from(date.day));
    let year = i64::from(date.year) - i64::from(month <= 2);
    // Days before a month, counted from March: 31, 30, 31, 30, 31 recur every five months.
    let before = (153 * ((month + 9) % 12) + 2) / 5;
    365 * year + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + before + day - 1
}

/// Seconds since the first of the moments; none if they are not all of one kind.
pub(super) fn seconds(moments: &[Moment]) -> Option<Vec<f64>> {
    let mut clock = Clock::at(*moments.first()?);
    moments.iter().map(|moment| clock.seconds(*moment)).collect()
}

/// A clock that shows seconds since its first moment, one moment after the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Clock {
    first: Moment,
    /// The last one, without its midnights.
    before: i128,
    midnights: i128,
}

impl Clock {
    /// A clock that begins at a moment.
    pub(super) fn at(first: Moment) -> Self {
        Self { first, before: first.nanoseconds, midnights: 0 }
    }

    /// Seconds since the first moment; none for a moment of another kind. A time of day that is more than half a day
    /// earlier than the one before is taken for one of the next day.
    pub(super) fn seconds(&mut self, moment: Moment) -> Option<f64> {
        if moment.origin != self.first.origin {
            return None;
        }
        let now = moment.nanoseconds;
        if self.first.origin == Origin::Midnight && self.before - now > DAY / 2 {
            self.midnights += 1;
        }
        self.before = now;
        // Rounded once: the difference is an integer below 2^53 for a hundred days, and the quotient is exact to an
        // ulp.
        Some((now + self.midnights * DAY - self.first.nanoseconds) as f64 / SECOND as f64)
    }

    /// Its content as words, from which [`from_words`](Self::from_words) makes it.
    pub(super) fn words(&self) -> String {
        let origin = match self.first.origin {
            Origin::Universal => "universal",
            Origin::Local => "local",
            Origin::Midnight => "midnight",
        };
        format!("{origin} {} {} {}", self.first.nanoseconds, self.before, self.midnights)
    }

    /// The clock of [`words`](Self::words).
    pub(super) fn from_words(words: &str) -> Option<Self> {
        let mut words = words.split(' ');
        let origin = match words.next()? {
            "universal" => Origin::Universal,
            "local" => Origin::Local,
            "midnight" => Origin::Midnight,
            _ => return None,
        };
        let mut number = || words.next()?.parse::<i128>().ok();
        let (nanoseconds, before, midnights) = (number()?, number()?, number()?);
        Some(Self { first: Moment { origin, nanoseconds }, before, midnights })
    }
}

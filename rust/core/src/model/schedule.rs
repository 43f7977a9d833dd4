//! A number as a function of time, by knots: constant before the first and after the last one.
//!
//! Between two knots, T apart and D = difference of their values, with s = (t - t_k)/T and the share e of easing:
//!
//!     rate    D/(T (1 - e)) w(s),   w = S(s/e) for s < e, 1, S((1 - s)/e) for s > 1 - e,   S(u) = 3 u^2 - 2 u^3
//!     value   v_k + D p(s),         p = e (u^3 - u^4/2)/(1 - e) for u = s/e < 1, (s - e/2)/(1 - e) up to s = 1/2
//!     area    T (v_k s + D P(s)),   P = e^2 (u^4/4 - u^5/10)/(1 - e), ((s - e/2)^2/2 + e^2/40)/(1 - e)
//!
//! and by symmetry p(s) = 1 - p(1 - s), P(s) = 1/2 - (1 - s) + P(1 - s). With easing, the rate and its derivative are
//! continuous; without, the rate jumps at the knots, where it is that of the later side.
//!
//! Two knots at one time are a jump: before it value and rate are those up to the first, from then on those from the
//! second. Of equal values, only the rate jumps.

use serde::Deserialize;

use crate::error::{Error, Result};

/// The most knots of a schedule.
pub const MOST_KNOTS: usize = 10_000;

/// A number as a function of time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "Knots")]
pub struct Schedule {
    knots: Knots,
    /// Integrals from the first knot to each.
    areas: Vec<f64>,
}

/// The knots of a schedule, as scenes give them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Knots {
    times: Vec<f64>,
    values: Vec<f64>,
    ease: f64,
}

/// A place in a schedule: between two knots, or beyond an end.
enum Place {
    /// Before the first knot or after the last one, with the value there.
    Beyond(usize),
    /// Between this knot and the next.
    Between(usize),
}

impl TryFrom<Knots> for Schedule {
    type Error = Error;

    fn try_from(knots: Knots) -> Result<Self> {
        check(&knots)?;
        let mut areas = vec![0.0];
        for k in 1..knots.times.len() {
            let mean = 0.5 * knots.values[k - 1] + 0.5 * knots.values[k];
            areas.push(areas[k - 1] + mean * (knots.times[k] - knots.times[k - 1]));
        }
        if let Some((index, &value)) = areas.iter().enumerate().find(|(_, area)| !area.is_finite()) {
            return Err(Error::Knot { what: "integral up to times", index, value, range: "it must be finite" });
        }
        Ok(Self { knots, areas })
    }
}

fn check(knots: &Knots) -> Result<()> {
    let Knots { times, values, ease } = knots;
    let count = times.len();
    if values.len() != count {
        return Err(Error::LengthMismatch {
            what: "values of a schedule",
            found: values.len(),
            expected: count,
            per: "time",
        });
    }
    if count == 0 || count > MOST_KNOTS {
        let range = "it must be 1 to 10000; give fewer times, the schedule rises evenly between them";
        return Err(Error::OutOfRange { what: "number of times of a schedule", value: count as f64, range });
    }
    if !(0.0..=0.5).contains(ease) {
        return Err(Error::OutOfRange { what: "ease of a schedule", value: *ease, range: "it must be 0 to 0.5" });
    }
    for (what, list) in [("times", times), ("values", values)] {
        if let Some((index, &value)) = list.iter().enumerate().find(|(_, value)| !value.is_finite()) {
            return Err(Error::Knot { what, index, value, range: "it must be finite" });
        }
    }
    for index in 1..count {
        let (value, length) = (times[index], times[index] - times[index - 1]);
        if length < 0.0 {
            return Err(Error::Knot {
                what: "times",
                index,
                value,
                range: "times must ascend; sort the knots by time",
            });
        }
        if length == 0.0 {
            if index > 1 && times[index - 2] == value {
                let range = "it is that of two knots before; a jump has two: leave out the one in the middle";
                return Err(Error::Knot { what: "times", index, value, range });
            }
            continue;
        }
        let (rate, eased) = ((values[index] - values[index - 1]) / (length * (1.0 - ease)), ease * length);
        if !length.is_finite() || !rate.is_finite() || (*ease > 0.0 && !(1.5 * rate / eased).is_finite()) {
            let range = "the value changes by too much since the time before to compute with; give SI units";
            return Err(Error::Knot { what: "times", index, value, range });
        }
    }
    Ok(())
}

impl Schedule {
    /// A schedule by its knots.
    ///
    /// # Errors
    /// `LengthMismatch`, `OutOfRange`, `Knot`: lists of different lengths; no knot, or more than `MOST_KNOTS`; `ease`
    /// outside 0 to 0.5; a number that is not finite; times that do not ascend, or are too near for the difference
    /// of their values; three knots at one time.
    pub fn new(times: Vec<f64>, values: Vec<f64>, ease: f64) -> Result<Self> {
        Self::try_from(Knots { times, values, ease })
    }

    /// Whether two of its values differ.
    pub fn varies(&self) -> bool {
        self.knots.values.windows(2).any(|pair| pair[0] != pair[1])
    }

    /// The value at `time`.
    pub fn value(&self, time: f64) -> f64 {
        let values = &self.knots.values;
        match self.place(time) {
            Place::Beyond(k) => values[k],
            Place::Between(k) => {
                let (early, [before, after]) = self.shares(k, time);
                let change = values[k + 1] - values[k];
                if early { values[k] + change * self.risen(before) } else { values[k + 1] - change * self.risen(after) }
            }
        }
    }

    /// The derivative of the value at `time`.
    pub fn rate(&self, time: f64) -> f64 {
        let Place::Between(k) = self.place(time) else { return 0.0 };
        let (early, [before, after]) = self.shares(k, time);
        let (share, ease) = (if early { before } else { after }, self.knots.ease);
        let weight = if share < ease { smooth(share / ease) } else { 1.0 };
        self.full_rate(k) * weight
    }

    /// The second derivative of the value at `time`.
    pub fn second(&self, time: f64) -> f64 {
        let Place::Between(k) = self.place(time) else { return 0.0 };
        let (early, [before, after]) = self.shares(k, time);
        let (share, ease) = (if early { before } else { after }, self.knots.ease);
        if share >= ease {
            return 0.0;
        }
        let u = share / ease;
        let slope = self.full_rate(k) * 6.0 * u * (1.0 - u) / (ease * self.length(k));
        if early { slope } else { -slope }
    }

    /// The integral of the value from the first knot to `time`, negative before it.
    pub fn integral(&self, time: f64) -> f64 {
        let Knots { times, values, .. } = &self.knots;
        match self.place(time) {
            Place::Beyond(k) => self.areas[k] + values[k] * (time - times[k]),
            Place::Between(k) => {
                let (early, [before, after]) = self.shares(k, time);
                let (length, change) = (self.length(k), values[k + 1] - values[k]);
                if early {
                    self.areas[k] + length * (values[k] * before + change * self.area(before))
                } else {
                    self.areas[k + 1] - length * (values[k + 1] * after - change * self.area(after))
                }
            }
        }
    }

    /// The value of largest magnitude.
    pub fn largest(&self) -> f64 {
        self.knots.values.iter().fold(0.0, |most: f64, &value| if value.abs() > most.abs() { value } else { most })
    }

    /// The rate of largest magnitude.
    pub fn largest_rate(&self) -> f64 {
        (1..self.areas.len())
            .filter(|&k| self.length(k - 1) > 0.0)
            .map(|k| self.full_rate(k - 1))
            .fold(0.0, |most: f64, rate| if rate.abs() > most.abs() { rate } else { most })
    }

    /// The times of its jumps.
    pub fn jumps(&self) -> impl Iterator<Item = f64> {
        let times = &self.knots.times;
        (1..times.len()).filter(|&k| times[k] == times[k - 1]).map(|k| times[k])
    }

    /// The times at which it jumps, or its rate does.
    pub fn breaks(&self) -> impl Iterator<Item = f64> {
        let Knots { times, ease, .. } = &self.knots;
        (0..times.len()).filter(|&k| *ease == 0.0 || (k > 0 && times[k] == times[k - 1])).map(|k| times[k])
    }

    /// The value from the last knot on.
    pub fn last(&self) -> f64 {
        self.knots.values[self.knots.values.len() - 1]
    }

    /// The times of the knots.
    pub fn times(&self) -> &[f64] {
        &self.knots.times
    }

    /// The values at the knots.
    pub fn values(&self) -> &[f64] {
        &self.knots.values
    }

    fn place(&self, time: f64) -> Place {
        let next = self.knots.times.partition_point(|&knot| knot <= time);
        match next {
            0 => Place::Beyond(0),
            _ if next == self.areas.len() => Place::Beyond(next - 1),
            _ => Place::Between(next - 1),
        }
    }

    fn length(&self, k: usize) -> f64 {
        self.knots.times[k + 1] - self.knots.times[k]
    }

    /// The rate between the eased shares.
    fn full_rate(&self, k: usize) -> f64 {
        (self.knots.values[k + 1] - self.knots.values[k]) / (self.length(k) * (1.0 - self.knots.ease))
    }

    /// Whether `time` is in the first half between a knot and the next, and the shares before and after it.
    fn shares(&self, k: usize, time: f64) -> (bool, [f64; 2]) {
        let (length, times) = (self.length(k), &self.knots.times);
        let (before, after) = ((time - times[k]) / length, (times[k + 1] - time) / length);
        (before <= after, [before, after])
    }

    /// p(s) for s up to one half.
    fn risen(&self, share: f64) -> f64 {
        let ease = self.knots.ease;
        if share >= ease {
            return (share - 0.5 * ease) / (1.0 - ease);
        }
        let u = share / ease;
        ease * u * u * u * (1.0 - 0.5 * u) / (1.0 - ease)
    }

    /// P(s) for s up to one half.
    fn area(&self, share: f64) -> f64 {
        let ease = self.knots.ease;
        if share >= ease {
            let shifted = share - 0.5 * ease;
            return (0.5 * shifted * shifted + ease * ease / 40.0) / (1.0 - ease);
        }
        let u = share / ease;
        ease * ease * u * u * u * u * (0.25 - 0.1 * u) / (1.0 - ease)
    }
}

fn smooth(u: f64) -> f64 {
    u * u * (3.0 - 2.0 * u)
}

//! What a golden program prints: a line `observer NAME`, a digest per step in hexadecimal digits and, on a board, four
//! costs.

use super::Cost;
use crate::step::Failure;
use std::fs;
use std::path::Path;

/// The steps of an observer.
pub(super) struct Golden {
    pub(super) name: String,
    digests: Vec<u32>,
    /// Instructions of an empty call, of the longest step, of all steps; bytes of stack.
    costs: Vec<u32>,
}

impl Golden {
    pub(super) fn differs(&self, how: &str, place: &str) -> Failure {
        Failure::Firmware(format!("{} {how} on {place}", self.name))
    }

    /// Whether the steps are the same.
    pub(super) fn compare(&self, found: &Golden, place: &str) -> Result<(), Failure> {
        if found.name != self.name {
            return Err(self.differs(&format!("is {}", found.name), place));
        }
        if found.digests.len() != self.digests.len() {
            let how = format!("has {} steps, not {},", found.digests.len(), self.digests.len());
            return Err(self.differs(&how, place));
        }
        match self.digests.iter().zip(&found.digests).position(|(x, y)| x != y) {
            None => Ok(()),
            Some(step) => Err(self.differs(&format!("has other bits in step {step}"), place)),
        }
    }

    pub(super) fn cost(&self, code: u64, frame: Option<u64>) -> Result<Cost, Failure> {
        let &[overhead, most, total, stack] = &self.costs[..] else {
            return Err(Failure::Firmware(format!("{} has no costs", self.name)));
        };
        let mean = f64::from(total) / self.digests.len() as f64 - f64::from(overhead);
        Ok(Cost { mean, most: most.saturating_sub(overhead), stack, frame, code, constants: None })
    }
}

/// The observers in the order in which they were printed.
pub(super) fn read(text: &str) -> Result<Vec<Golden>, Failure> {
    let mut all: Vec<Golden> = Vec::new();
    let mut is_cost = false;
    for line in text.lines() {
        if let Some(name) = line.strip_prefix("observer ") {
            all.push(Golden { name: name.to_owned(), digests: Vec::new(), costs: Vec::new() });
            is_cost = false;
        } else if line.starts_with("overhead") {
            is_cost = true;
        } else {
            let number = u32::from_str_radix(line, 16);
            let (Ok(number), Some(last)) = (number, all.last_mut()) else {
                return Err(Failure::Firmware(format!("a golden program printed {line:?}")));
            };
            if is_cost { last.costs.push(number) } else { last.digests.push(number) }
        }
    }
    if all.is_empty() {
        return Err(Failure::Firmware("a golden program printed nothing".to_owned()));
    }
    Ok(all)
}

/// The names of the exported observers.
pub(super) fn exported(folder: &Path) -> Result<Vec<String>, Failure> {
    let entries = fs::read_dir(folder).map_err(|source| Failure::io(folder, source))?;
    let mut names: Vec<String> =
        entries.filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().into_owned())).collect();
    names.sort();
    Ok(names)
}

/// The steps of one observer among all.
pub(super) fn of<'a>(golden: &'a [Golden], name: &str) -> Result<&'a Golden, Failure> {
    let missing = || Failure::Firmware(format!("{name} was exported and not run"));
    golden.iter().find(|golden| golden.name == name).ok_or_else(missing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_bit_is_found() {
        let one = &read("observer a\n00000001\n00000002\n").unwrap()[0];
        let same =
            &read("observer a\n00000001\n00000002\noverhead\n00000001\n00000009\n00000010\n00000020\n").unwrap()[0];
        assert!(one.compare(same, "here").is_ok());
        let cost = same.cost(100, None).unwrap();
        assert_eq!((cost.mean, cost.most, cost.stack), (7.0, 8, 32));
        for (other, said) in [
            ("observer a\n00000001\n00000003\n", "a has other bits in step 1 on here"),
            ("observer a\n00000001\n", "a has 1 steps, not 2, on here"),
            ("observer b\n00000001\n00000002\n", "a is b on here"),
        ] {
            let failure = one.compare(&read(other).unwrap()[0], "here").unwrap_err();
            assert_eq!(failure.to_string(), said);
        }
        assert!(read("observer a\nqemu: not a number\n").is_err());
        assert!(read("").is_err());
    }
}

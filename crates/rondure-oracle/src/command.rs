//! What the commands have in common: numbers that are checked, and what happens if something is wrong.

use std::process::ExitCode;

/// Does the work if the options are in order; shows the usage if help is asked for, or else what is wrong.
pub(crate) fn answer<T>(
    options: Result<Option<T>, String>,
    usage: &str,
    work: impl FnOnce(T) -> ExitCode,
) -> ExitCode {
    match options {
        Ok(Some(options)) => work(options),
        Ok(None) => {
            println!("{usage}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("{message}\n{usage}");
            ExitCode::from(2)
        }
    }
}

/// A whole number, which may be written like 1e7.
pub(crate) fn number(name: &str, value: &str) -> Result<u64, String> {
    match value.parse::<f64>() {
        Ok(number) if (0.0..=1e15).contains(&number) && number.fract() == 0.0 => Ok(number as u64),
        _ => Err(format!("{name}: {value} is no whole number from 0 to 1e15")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_whole_and_not_negative() {
        assert_eq!(number("--rays", "1e7"), Ok(10_000_000));
        assert_eq!(number("--rays", "0"), Ok(0));
        for wrong in ["-1", "0.5", "nan", "inf", "1e16", "many", ""] {
            assert!(number("--rays", wrong).is_err(), "{wrong}");
        }
    }
}

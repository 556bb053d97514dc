//! The options that choose an engine, for the commands that trace rays.

use clap::{
    Args, ValueEnum,
    builder::{PossibleValuesParser, TypedValueParser},
};
use rondure::{EngineOptions, Method, engine::Criterion};

#[derive(Debug, Args)]
pub(crate) struct EngineArgs {
    /// How hits are found. `wide` and `exact` work on the profile's curves and find the same hits; the
    /// others are the methods of Wang, Zhu and Gu 2008, on frusta: kj, cy, co, hy, and bs
    #[arg(long, value_parser = method_parser(), default_value = "wide", help_heading = ENGINE)]
    engine: Method,

    /// Frusta: 2^K leaves in each monotone interval of the profile; 4 if not given
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(..=31), help_heading = ENGINE)]
    subdivide: Option<u32>,

    /// Frusta: about how many points the profile is sampled at; 1000 if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000), help_heading = ENGINE)]
    samples: Option<u32>,

    /// hy: what its shells minimise; area if not given
    #[arg(long, value_enum, help_heading = ENGINE)]
    criterion: Option<CriterionName>,
}

const ENGINE: &str = "Engine, for comparisons";

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum CriterionName {
    /// The area of the shell's section
    Area,
    /// The mean length of the intersection interval
    Interval,
}

fn method_parser() -> impl TypedValueParser<Value = Method> {
    PossibleValuesParser::new(Method::ALL.map(|(_, name)| name)).try_map(|name| {
        let found = Method::ALL.into_iter().find(|(_, own)| *own == name);
        found.map(|(method, _)| method).ok_or("no such engine")
    })
}

impl EngineArgs {
    pub(crate) fn options(&self) -> EngineOptions {
        let usual = EngineOptions::default();
        let criterion = match self.criterion {
            Some(CriterionName::Interval) => Criterion::Interval,
            Some(CriterionName::Area) | None => usual.criterion,
        };
        EngineOptions {
            method: self.engine,
            criterion,
            samples: self.samples.unwrap_or(usual.samples),
            subdivide: self.subdivide.unwrap_or(usual.subdivide),
            ..usual
        }
    }

    /// The engine in words, all of them that decide what it finds.
    pub(crate) fn describe(&self) -> String {
        let EngineOptions { method, criterion, samples, subdivide, .. } = self.options();
        let name = method.name();
        match method {
            Method::Wide | Method::Exact => name.to_owned(),
            _ => format!("{name}, {samples} samples, subdivide {subdivide}, {criterion:?}"),
        }
    }
}

//! `raystep bench --serve`: the program that is ordered to run; see [`super::protocol`].

use std::io::{self, BufRead as _, Write as _};

use raystep_lab::bench::Served;
use raystep_lab::meter::Meter;

use super::protocol::{Answer, PROTOCOL, Request};
use super::{BenchArgs, read_scenes};
use crate::device;
use crate::error::{Error, reason};
use crate::terminal::Progress;

pub(super) fn run(args: &BenchArgs) -> Result<(), Error> {
    answer(&Answer::Hello { protocol: PROTOCOL, raystep_version: env!("CARGO_PKG_VERSION").into() })?;
    let mut requests = io::stdin().lock().lines();
    let mut next = || match requests.next() {
        None => Ok(None),
        Some(Err(error)) => Err(Error::failed(format!("cannot read a request: {}", reason(&error)))),
        Some(Ok(line)) => match Request::read(&line) {
            Some(request) => Ok(Some(request)),
            None => Err(Error::failed(format!("\"{line}\" is not a request: expected \"build full\" or \"run N\""))),
        },
    };
    let is_brief = match next()? {
        None => return Ok(()),
        Some(Request::Build { is_brief }) => is_brief,
        Some(Request::Run(_)) => return Err(Error::failed("nothing is built yet: expected \"build full\"")),
    };
    let progress = Progress::new(true);
    let (_, subjects) = read_scenes(args, None, &progress)?;
    let (meter, wanted) = (Meter::new(device::choose(&args.device())?), args.wanted()?);
    let mut served = Served::new(&wanted, &subjects, is_brief, &meter, &progress)?;
    answer(&Answer::Ready { configurations: served.announced(), notes: std::mem::take(&mut served.notes) })?;
    while let Some(request) = next()? {
        let Request::Run(place) = request else { return Err(Error::failed("everything is built: expected \"run N\"")) };
        let run = served.run(place)?;
        answer(&Answer::Run(run.ok_or_else(|| Error::failed(format!("there is no configuration {place}")))?))?;
    }
    Ok(())
}

/// Writes an answer. Not by [`crate::terminal::print`], which would escape characters within JSON.
fn answer(answer: &Answer) -> Result<(), Error> {
    let cannot = |why: &dyn std::fmt::Display| Error::failed(format!("cannot answer: {why}"));
    let line = serde_json::to_string(answer).map_err(|e| cannot(&e))?;
    let mut out = io::stdout().lock();
    writeln!(out, "{line}").and_then(|()| out.flush()).map_err(|e| cannot(&reason(&e)))
}

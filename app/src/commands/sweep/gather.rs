//! The results of all jobs as one table, with its schema and a page.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use raystep_kernels::export::csv::writer;
use raystep_lab::Hash;
use raystep_lab::report::SECTIONS;
use raystep_lab::tidy::package::{self, Resource};
use serde_json::{Value, json};

use super::drive::{Failure, Place};
use super::file::{Definition, What};
use super::job::{self, Done};
use super::page;
use super::plan::Job;
use crate::commands::json_text;
use crate::commands::merge::{self, MergeArgs};
use crate::error::Error;
use crate::output::{self, Target};
use crate::scene_file::bytes_of;
use crate::shard::{self, Part};

const RESULTS: &str = "results.csv";
const PAGE: &str = "index.html";
/// Files that are written.
pub(super) const NAMES: [&str; 3] = [RESULTS, package::FILE, PAGE];

/// The folder of images that are merged from parts.
const IMAGES: &str = "images";
/// The folder of images some of whose parts are finished.
const SO_FAR: &str = "images/so-far";

/// Most bytes of a job's table or image.
const MOST_BYTES: u64 = 1 << 32;

/// Columns that only this table has, with their types and meanings.
const OWN: [(&str, &str, &str); 9] = [
    ("job", "string", "name of the job and of its folder in jobs"),
    ("host", "string", "name of the machine that ran it"),
    (
        "is_shared",
        "boolean",
        "whether something else ran on the machine meanwhile, or may have; empty if nothing was timed",
    ),
    ("table", "string", "section of the report"),
    ("image", "string", "the image's file"),
    ("image_hash", "string", "hash of that file, with the method as prefix"),
    ("trace_s", "number", "seconds of tracing, by the host's clock"),
    ("job_s", "number", "seconds of the job's process, or of all for an image in parts"),
    ("hits", "integer", "rays that hit a triangle, of all samples of an image"),
];

/// Fields of a row by column; columns that are missing are unknown.
pub(super) type Row = BTreeMap<String, String>;

/// Rows with their columns.
#[derive(Default)]
pub(super) struct Table {
    columns: Vec<String>,
    known: BTreeSet<String>,
    pub(super) rows: Vec<Row>,
}

impl Table {
    /// Adds a row, and the columns that it is the first to have.
    fn add(&mut self, fields: impl IntoIterator<Item = (String, String)>) {
        let mut row = Row::new();
        for (column, field) in fields {
            if self.known.insert(column.clone()) {
                self.columns.push(column.clone());
            }
            // The first one counts: scene and adapter are among a job's own columns, too.
            row.entry(column).or_insert(field);
        }
        self.rows.push(row);
    }

    /// RFC 4180.
    fn csv(&self) -> std::io::Result<Vec<u8>> {
        let mut file = Vec::new();
        let mut csv = writer(&mut file);
        csv.write_record(&self.columns)?;
        for row in &self.rows {
            csv.write_record(self.columns.iter().map(|column| row.get(column).map_or("", String::as_str)))?;
        }
        csv.flush()?;
        drop(csv);
        Ok(file)
    }

    /// The schema.
    fn package(&self) -> Value {
        let columns: Vec<&str> = self.columns.iter().map(String::as_str).collect();
        let resource = Resource { file: RESULTS, what: "a result of a job", columns: &columns };
        let mut package = package::describe("raystep-sweep", "raystep sweep", &[resource]);
        for field in package["resources"][0]["schema"]["fields"].as_array_mut().into_iter().flatten() {
            let name = field["name"].as_str().unwrap_or_default().to_owned();
            if let Some((_, kind, what)) = OWN.iter().find(|(own, _, _)| *own == name) {
                *field = json!({ "name": name, "type": kind, "description": what });
            } else if let Some(option) = name.strip_prefix("option_") {
                let what = format!("value of --{} of the job", option.replace('_', "-"));
                *field = json!({ "name": name, "type": "string", "description": what });
            }
        }
        package
    }
}

/// What was gathered.
pub(super) struct Gathered {
    /// Jobs with results.
    pub(super) finished: usize,
    /// Jobs whose results are failures, and images that could not be merged.
    pub(super) failures: Vec<Failure>,
}

/// Writes the files.
pub(super) fn gather(sweep: &Definition, jobs: &[Job], place: &Place, failed: &[Failure]) -> Result<Gathered, Error> {
    let done: Vec<(&Job, Done)> = jobs.iter().filter_map(|job| Some((job, place.done(job)?))).collect();
    let mut failures = Vec::new();
    let mut table = Table::default();
    for (job, done) in &done {
        failures
            .extend(done.verdict.iter().map(|message| Failure { name: job.name.clone(), message: message.clone() }));
        if job.part_of.is_none() {
            add(&mut table, job, done, place)?;
        }
    }
    for image in images(jobs) {
        let parts: Vec<&(&Job, Done)> = done.iter().filter(|(job, _)| job.part_of.as_ref() == Some(&image)).collect();
        let of = jobs.iter().filter(|job| job.part_of.as_ref() == Some(&image)).count();
        if parts.len() < of {
            continue;
        }
        match merge_parts(&image, &parts, place) {
            Ok(file) => add_merged(&mut table, &image, &parts, &file, place)?,
            Err(error) => failures.push(Failure { name: image, message: error.message }),
        }
    }
    let all: Vec<&Failure> = failed.iter().chain(&failures).collect();
    let page = page::html(sweep.what, &table, [done.len(), jobs.len()], &all);
    let csv = table.csv().map_err(|e| Error::failed(format!("cannot write {RESULTS}: {e}")))?;
    let schema = json_text(&table.package())?.into_bytes();
    let files = NAMES.into_iter().zip([csv, schema, page.into_bytes()]);
    let files = files.map(|(name, bytes)| Ok((Target::new(&place.path.join(name))?, bytes)));
    output::write(files.collect::<Result<_, Error>>()?)?;
    Ok(Gathered { finished: done.len(), failures })
}

/// Images in parts, in order.
fn images(jobs: &[Job]) -> Vec<String> {
    super::super::distinct(&jobs.iter().filter_map(|job| job.part_of.clone()).collect::<Vec<_>>())
}

/// The columns that every row starts with.
fn lead(name: &str, job: &Job, host: &str, adapter: &str, is_shared: Option<bool>) -> Vec<(String, String)> {
    let field = |column: &str, field: &str| (column.to_owned(), field.to_owned());
    let options =
        job.each.iter().map(|(option, value)| (format!("option_{}", option.replace('-', "_")), value.clone()));
    let shared = is_shared.map(|is_shared| is_shared.to_string()).unwrap_or_default();
    let first = [field("job", name), field("scene", &job.scene), field("host", host), field("adapter", adapter)];
    first.into_iter().chain(options).chain([field("is_shared", &shared)]).collect()
}

/// Adds the rows of a job.
fn add(table: &mut Table, job: &Job, done: &Done, place: &Place) -> Result<(), Error> {
    let folder = place.folder(&job.name);
    let tables: Vec<(&str, Option<&str>)> = match job.what() {
        Some(What::Bench) => vec![("summary.csv", None)],
        Some(What::Stability) => vec![("stability.csv", None)],
        Some(What::Report) => SECTIONS.iter().map(|section| (section.file, Some(section.name))).collect(),
        Some(What::Render) | None => return add_image(table, job, done, &folder),
    };
    for (file, section) in tables {
        let path = folder.join(file);
        if !path.exists() {
            continue;
        }
        let bytes = bytes_of(&path, MOST_BYTES)?;
        let unreadable = |e: csv::Error| Error::at(&path, e);
        let mut reader = csv::Reader::from_reader(bytes.as_slice());
        let names = reader.headers().map_err(unreadable)?.clone();
        for record in reader.records() {
            let record = record.map_err(unreadable)?;
            let own: Vec<(&str, &str)> = names.iter().zip(record.iter()).collect();
            let of = |name: &str| own.iter().find(|(column, _)| *column == name).map_or("", |(_, field)| *field);
            let mut fields = lead(&job.name, job, &done.host, of("adapter"), done.is_shared);
            fields.extend(section.map(|section| ("table".to_owned(), section.to_owned())));
            fields.extend(own.iter().map(|(column, field)| ((*column).to_owned(), (*field).to_owned())));
            table.add(fields);
        }
    }
    Ok(())
}

/// Adds the row of an image.
fn add_image(table: &mut Table, job: &Job, done: &Done, folder: &Path) -> Result<(), Error> {
    let file = format!("image.{}", job.format);
    let at = folder.join(job::SUMMARY);
    let summary: Value = serde_json::from_slice(&bytes_of(&at, MOST_BYTES)?).map_err(|e| Error::at(&at, e))?;
    let adapter = summary["adapter"]["name"].as_str().unwrap_or("cpu");
    let number = |value: &Value| if value.is_null() { String::new() } else { value.to_string() };
    let mut fields = lead(&job.name, job, &done.host, adapter, done.is_shared);
    let own = [
        ("image", format!("jobs/{}/{file}", job.name)),
        ("image_hash", Hash::of(&bytes_of(&folder.join(&file), MOST_BYTES)?).to_string()),
        ("trace_s", number(&summary["seconds"]["trace"])),
        ("job_s", done.job_s.to_string()),
        ("triangles", number(&summary["triangles"])),
        ("passes", number(&summary["passes"])),
        ("rays", number(&summary["rays"])),
        ("hits", number(&summary["hits"])),
    ];
    fields.extend(own.map(|(column, field)| (column.to_owned(), field)));
    table.add(fields);
    Ok(())
}

/// Shows images while their parts are traced: after each part, the image of those that are finished.
pub(super) struct SoFar<'a> {
    jobs: &'a [Job],
    place: &'a Place,
    /// When the last image was written, and how long it took.
    last: Option<(Instant, Duration)>,
}

impl<'a> SoFar<'a> {
    pub(super) fn new(jobs: &'a [Job], place: &'a Place) -> Self {
        Self { jobs, place, last: None }
    }

    /// Writes the image of which a job has traced a part, unless that would take more than a tenth of the time.
    pub(super) fn show(&mut self, ended: &str) {
        let job = self.jobs.iter().find(|job| job.name == ended);
        let Some(image) = job.and_then(|job| job.part_of.as_ref()) else { return };
        if self.last.is_some_and(|(end, took)| end.elapsed() < took * 10) {
            return;
        }
        let begin = Instant::now();
        let of_image = self.jobs.iter().filter(|job| job.part_of.as_ref() == Some(image));
        let parts = of_image.map(|job| self.place.folder(&job.name).join("part"));
        let parts: Vec<PathBuf> = parts.filter(|part| part.join(shard::FILE).exists()).collect();
        let path = self.place.path.join(SO_FAR);
        let output = path.join(format!("{image}.png"));
        // It is only to be looked at: what is wrong with a part, the merge of all says.
        let _ = fs::create_dir_all(&path).map(|()| merge::run(&MergeArgs::so_far(parts, output)));
        self.last = Some((Instant::now(), begin.elapsed()));
    }
}

/// Merges the parts of an image. Returns the file, as seen from the output folder.
fn merge_parts(image: &str, parts: &[&(&Job, Done)], place: &Place) -> Result<PathBuf, Error> {
    let format = parts.first().map_or("png", |(job, _)| job.format.as_str());
    let name = format!("{image}.{format}");
    let folders = parts.iter().map(|(job, _)| place.folder(&job.name).join("part")).collect();
    let images = place.path.join(IMAGES);
    fs::create_dir_all(&images).map_err(|e| Error::cannot_write(&images, &e))?;
    merge::run(&MergeArgs::complete(folders, images.join(&name)))?;
    let so_far = place.path.join(SO_FAR);
    // The folder goes with its last file.
    let _ = fs::remove_file(so_far.join(format!("{image}.png"))).and_then(|()| fs::remove_dir(so_far));
    Ok(Path::new(IMAGES).join(name))
}

/// Adds the row of an image that was merged.
fn add_merged(
    table: &mut Table,
    image: &str,
    parts: &[&(&Job, Done)],
    file: &Path,
    place: &Place,
) -> Result<(), Error> {
    let Some((job, _)) = parts.first() else { return Ok(()) };
    let hosts: BTreeSet<&str> = parts.iter().map(|(_, done)| done.host.as_str()).collect();
    let about = parts.iter().filter_map(|(job, _)| Part::read(&place.folder(&job.name).join("part")).ok().flatten());
    let adapters: BTreeSet<String> = about.map(|part| part.device).collect();
    let hosts = hosts.into_iter().collect::<Vec<_>>().join("; ");
    let adapters = adapters.into_iter().collect::<Vec<_>>().join("; ");
    let seconds: f64 = parts.iter().map(|(_, done)| done.job_s).sum();
    let mut fields = lead(image, job, &hosts, &adapters, None);
    let own = [
        ("image", file.to_string_lossy().replace('\\', "/")),
        ("image_hash", Hash::of(&bytes_of(&place.path.join(file), MOST_BYTES)?).to_string()),
        ("job_s", seconds.to_string()),
    ];
    fields.extend(own.map(|(column, field)| (column.to_owned(), field)));
    table.add(fields);
    Ok(())
}

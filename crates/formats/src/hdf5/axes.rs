//! Dimension scales: the coordinates of HDF5 and NetCDF-4.

use std::collections::HashMap;

use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Datatype};

use super::Walk;
use crate::{Attributes, Coordinate, Value};

/// The name of a scale that NetCDF-4 makes for a dimension without coordinates.
const NO_VARIABLE: &str = "This is a netCDF dimension but not a netCDF variable";
/// NetCDF-4 puts this before a variable that has the name of a dimension without being its coordinate.
const NO_COORDINATE: &str = "_nc4_non_coord_";

/// For each dimension of a data set with these attributes, the object headers of its scales.
pub(super) fn scales(parent: &Group, found: &[Attribute], dimensions: usize) -> Vec<Vec<u64>> {
    let list = found.iter().find(|found| found.name == "DIMENSION_LIST");
    let Some(list) = list else {
        return Vec::new();
    };
    let Datatype::VarLen { base, .. } = &list.datatype else {
        return Vec::new();
    };
    let Datatype::Reference { size, .. } = **base else {
        return Vec::new();
    };
    let size = usize::from(size);
    let offset_size = usize::from(parent.offset_size());
    let entries = list.raw_data.chunks_exact(8 + offset_size);
    if entries.len() != dimensions || size < offset_size {
        return Vec::new();
    }
    let scales = entries.map(|entry| {
        let bytes = parent
            .resolve_vlen_reference_bytes(entry, size)
            .unwrap_or_default();
        let references = bytes.chunks_exact(size);
        let address = |one: &[u8]| {
            let mut address = [0; 8];
            let used = offset_size.min(8);
            address[..used].copy_from_slice(&one[..used]);
            u64::from_le_bytes(address)
        };
        references.map(address).collect()
    });
    scales.collect()
}

/// Names the dimensions, finds their coordinates, and drops what is only the name of a dimension.
pub(super) fn assign(walk: &mut Walk) {
    let by_address: HashMap<u64, usize> = walk
        .objects
        .iter()
        .enumerate()
        .filter_map(|(i, object)| Some((object.address?, i)))
        .collect();
    let is_name_only: Vec<bool> = walk
        .variables
        .iter()
        .map(|v| is_scale(&v.attributes) && is_name_only(&v.attributes))
        .collect();
    // Places of the variables once the mere names are gone.
    let mut next = 0;
    let places: Vec<Option<usize>> = is_name_only
        .iter()
        .map(|&is_name_only| {
            (!is_name_only).then(|| {
                next += 1;
                next - 1
            })
        })
        .collect();
    let names: Vec<String> = walk.variables.iter().map(|v| name(&v.path)).collect();
    let lengths: Vec<Vec<u64>> = walk.variables.iter().map(|v| v.shape()).collect();
    let is_number: Vec<bool> = walk
        .variables
        .iter()
        .map(|v| v.sample_type.number().is_some())
        .collect();
    for (i, (variable, object)) in walk.variables.iter_mut().zip(&walk.objects).enumerate() {
        let labels = match variable.attributes.get("DIMENSION_LABELS") {
            Some(Value::Texts(labels)) => labels.clone(),
            Some(Value::Text(label)) => vec![label.clone()],
            _ => Vec::new(),
        };
        let is_own = is_scale(&variable.attributes) && variable.dimensions.len() == 1;
        for (d, dimension) in variable.dimensions.iter_mut().enumerate() {
            let listed = object.scales.get(d).into_iter().flatten();
            let mut scales = listed.filter_map(|address| by_address.get(address).copied());
            let scale = if is_own { Some(i) } else { scales.next() };
            let label = labels.get(d).filter(|label| !label.is_empty()).cloned();
            dimension.name = label.or_else(|| scale.map(|scale| names[scale].clone()));
            let Some(scale) = scale else { continue };
            if lengths[scale] == [dimension.len] && is_number[scale] {
                dimension.coordinate = places[scale].map(Coordinate::Listed);
            }
        }
        let hidden: &[&str] = match is_scale(&variable.attributes) {
            true => &["CLASS", "NAME", "DIMENSION_LABELS"],
            false => &["DIMENSION_LABELS"],
        };
        variable.attributes.0.retain(|(name, _)| {
            !hidden.contains(&name.as_str())
                && !matches!(name.as_str(), "_Netcdf4Dimid" | "_Netcdf4Coordinates")
        });
    }
    let mut kept = is_name_only.iter().map(|only| !only);
    walk.variables.retain(|_| kept.next().unwrap_or(true));
    let mut kept = is_name_only.iter().map(|only| !only);
    walk.objects.retain(|_| kept.next().unwrap_or(true));
}

fn is_scale(attributes: &Attributes) -> bool {
    attributes.text("CLASS") == Some("DIMENSION_SCALE")
}

fn is_name_only(attributes: &Attributes) -> bool {
    let name = attributes.text("NAME");
    name.is_some_and(|name| name.starts_with(NO_VARIABLE))
}

fn name(path: &str) -> String {
    let name = path.rsplit('/').next().unwrap_or(path);
    name.strip_prefix(NO_COORDINATE).unwrap_or(name).to_owned()
}

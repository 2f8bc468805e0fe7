//! Dimension scales: the coordinates of HDF5 and NetCDF-4.

use std::collections::HashMap;

use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Datatype};

use super::Walk;
use crate::{Attributes, ByteOrder, Coordinate, Value, Variable};

/// The name of a scale that NetCDF-4 makes for a dimension without coordinates.
const NO_VARIABLE: &str = "This is a netCDF dimension but not a netCDF variable";
/// NetCDF-4 puts this before a variable that has the name of a dimension without being its coordinate.
const NO_COORDINATE: &str = "_nc4_non_coord_";

/// For each dimension of a data set with these attributes, the object headers of its scales.
pub(super) fn scales(parent: &Group, found: &[Attribute], dimensions: usize) -> Vec<Vec<u64>> {
    let list = found.iter().find(|found| found.name == "DIMENSION_LIST");
    let base = list.and_then(|list| match &list.datatype {
        Datatype::VarLen { base, .. } => Some((list, &**base)),
        _ => None,
    });
    let Some((list, Datatype::Reference { size, .. })) = base else {
        return Vec::new();
    };
    let size = usize::from(*size);
    let offset_size = usize::from(parent.offset_size());
    let entries = list.raw_data.chunks_exact(8 + offset_size);
    if entries.len() != dimensions || size < offset_size {
        return Vec::new();
    }
    let scales = entries.map(|entry| {
        let bytes = parent.resolve_vlen_reference_bytes(entry, size);
        let bytes = bytes.unwrap_or_default();
        let address = |one: &[u8]| ByteOrder::Little.unsigned(&one[..offset_size.min(8)]);
        bytes.chunks_exact(size).map(address).collect()
    });
    scales.collect()
}

/// What a variable is to the dimensions of others.
struct Scale {
    name: String,
    shape: Vec<u64>,
    /// Its place among the variables that are kept; none for what is only the name of a dimension.
    place: Option<usize>,
    is_number: bool,
}

/// Names the dimensions, finds their coordinates, and drops what is only the name of a dimension.
pub(super) fn assign(walk: &mut Walk) {
    let addresses = walk.objects.iter().enumerate();
    let addresses = addresses.filter_map(|(i, object)| Some((object.address?, i)));
    let by_address: HashMap<u64, usize> = addresses.collect();
    let mut kept = 0;
    let scale = |variable: &Variable| {
        let attributes = &variable.attributes;
        let is_kept = !(is_scale(attributes) && is_name_only(attributes));
        kept += usize::from(is_kept);
        Scale {
            name: name(&variable.path),
            shape: variable.shape(),
            place: is_kept.then(|| kept - 1),
            is_number: variable.sample_type.number().is_some(),
        }
    };
    let scales: Vec<Scale> = walk.variables.iter().map(scale).collect();
    for (i, (variable, object)) in walk.variables.iter_mut().zip(&walk.objects).enumerate() {
        let attributes = &mut variable.attributes;
        let labels = match attributes.get("DIMENSION_LABELS") {
            Some(Value::Texts(labels)) => labels.clone(),
            Some(Value::Text(label)) => vec![label.clone()],
            _ => Vec::new(),
        };
        let is_scale = is_scale(attributes);
        let is_own = is_scale && variable.dimensions.len() == 1;
        for (d, dimension) in variable.dimensions.iter_mut().enumerate() {
            let mut listed = object.scales.get(d).into_iter().flatten();
            let listed = listed.find_map(|address| by_address.get(address).copied());
            let scale = if is_own { Some(i) } else { listed };
            let scale = scale.map(|scale| &scales[scale]);
            let label = labels.get(d).filter(|label| !label.is_empty()).cloned();
            dimension.name = label.or_else(|| scale.map(|scale| scale.name.clone()));
            let fits = |scale: &&Scale| scale.is_number && scale.shape == [dimension.len];
            let place = scale.filter(fits).and_then(|scale| scale.place);
            dimension.coordinate = place.map(Coordinate::Listed);
        }
        attributes.0.retain(|name, _| match name.as_str() {
            "CLASS" | "NAME" => !is_scale,
            "DIMENSION_LABELS" | "_Netcdf4Dimid" | "_Netcdf4Coordinates" => false,
            _ => true,
        });
    }
    let mut is_kept = scales.iter().map(|scale| scale.place.is_some());
    walk.variables.retain(|_| is_kept.next().unwrap_or(true));
    let mut is_kept = scales.iter().map(|scale| scale.place.is_some());
    walk.objects.retain(|_| is_kept.next().unwrap_or(true));
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

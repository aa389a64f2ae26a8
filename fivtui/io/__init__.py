"""Files and tables: locked, atomic, with units and provenance."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .column_files import read_columns as read_columns, read_provenance as read_provenance
    from .files import (
        Named as Named,
        check_apart as check_apart,
        check_output as check_output,
        check_suffix as check_suffix,
        parts_folder as parts_folder,
        resolved as resolved,
        save_bytes as save_bytes,
        save_json as save_json,
        write_atomically as write_atomically,
    )
    from .finite import check_finite as check_finite, not_finite_error as not_finite_error
    from .formats import (
        FORMATS as FORMATS,
        Columns as Columns,
        Provenance as Provenance,
        check_columns_path as check_columns_path,
        columns_format as columns_format,
    )
    from .locks import Locked as Locked, locked as locked
    from .reading import (
        MAX_TABLE as MAX_TABLE,
        MAX_TEXT as MAX_TEXT,
        check_regular as check_regular,
        is_folder as is_folder,
        is_there as is_there,
        opened as opened,
        read_bytes as read_bytes,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)

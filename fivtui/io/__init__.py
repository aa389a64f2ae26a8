"""Files and tables: locked, atomic, with units and provenance."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .csv_format import (
        UNITS,
        csv_cell,
        csv_quoted,
        read_csv,
        save_csv,
        write_csv_head,
        write_csv_rows,
    )
    from .files import (
        Named,
        check_apart,
        check_output,
        check_suffix,
        files_text,
        is_replaceable,
        output_path,
        parts_folder,
        resolved,
    )
    from .finite import check_finite, not_finite_error
    from .limits import limit_error, temporary_folder
    from .locks import Locked, locked
    from .npz_format import npz_arrays
    from .parquet_format import parquet_schema
    from .reading import MAX_TABLE, MAX_TEXT, check_regular, is_folder, is_there, opened, read_bytes
    from .tables import (
        FORMATS,
        Columns,
        Format,
        Header,
        check_table_path,
        read_columns,
        read_header,
        table_format,
        write_table,
    )
    from .writing import TEMPORARY_FILES, save_bytes, save_json, write_atomically, written_together
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)

"""Read and write files: atomic writing, locks, and tables with units and a header."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .csv_format import (
        UNITS,
        csv_cell,
        quote_csv,
        read_csv,
        save_csv,
        write_csv_header,
        write_csv_rows,
    )
    from .files import (
        LabelledPath,
        check_distinct,
        check_output,
        check_suffix,
        describe_files,
        home_path,
        is_replaceable,
        output_path,
        parts_folder,
        resolve_path,
    )
    from .limits import system_limit_error, temporary_folder
    from .npz_format import npz_arrays
    from .parquet_format import parquet_schema
    from .reading import (
        MAX_TABLE,
        MAX_TEXT,
        check_regular,
        is_folder,
        open_regular,
        path_exists,
        read_bytes,
    )
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
    from .writing import (
        TEMPORARY_GLOB,
        LockedError,
        hold_lock,
        publish_together,
        save_bytes,
        save_json,
        write_atomically,
    )
else:
    from fivtui.lazy import lazy_exports

    __getattr__, __dir__ = lazy_exports(__name__)

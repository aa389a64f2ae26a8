"""Files and tables: locked, atomic, with units and provenance."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .csv_format import (
        UNITS as UNITS,
        csv_cell as csv_cell,
        csv_quoted as csv_quoted,
        read_csv as read_csv,
        write_csv_head as write_csv_head,
        write_csv_numbers as write_csv_numbers,
        write_csv_rows as write_csv_rows,
    )
    from .files import (
        Named as Named,
        check_apart as check_apart,
        check_output as check_output,
        check_suffix as check_suffix,
        files_text as files_text,
        parts_folder as parts_folder,
        resolved as resolved,
    )
    from .finite import check_finite as check_finite, not_finite_error as not_finite_error
    from .limits import limit_error as limit_error, temporary_folder as temporary_folder
    from .locks import Locked as Locked, locked as locked
    from .npz_format import npz_arrays as npz_arrays
    from .parquet_format import parquet_schema as parquet_schema
    from .reading import (
        MAX_TABLE as MAX_TABLE,
        MAX_TEXT as MAX_TEXT,
        check_regular as check_regular,
        is_folder as is_folder,
        is_there as is_there,
        opened as opened,
        read_bytes as read_bytes,
    )
    from .tables import (
        FORMATS as FORMATS,
        Columns as Columns,
        Format as Format,
        Header as Header,
        check_table_path as check_table_path,
        read_columns as read_columns,
        read_header as read_header,
        table_format as table_format,
        write_table as write_table,
    )
    from .writing import (
        TEMPORARY_FILES as TEMPORARY_FILES,
        save_bytes as save_bytes,
        save_json as save_json,
        write_atomically as write_atomically,
        written_together as written_together,
    )
else:
    from fivtui.lazy import lazily

    __getattr__, __dir__ = lazily(__name__)
